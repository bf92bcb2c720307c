/* hetab shader: the model as source text. */
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "options.h"
#include "output.h"

typedef struct request {
  const char *surface, *output;
  int language, force;
} request;

static int save(hetab_context *ctx, const request *r, const char *text) {
  if (!r->output)
    return fputs(text, stdout), CLI_OK;
  CLI_CALL(ctx, hetab_text_save(ctx, r->output, text, strlen(text), r->force));
  int status = cli_publish(ctx);
  return status < 0 ? CLI_OK : status;
}

static int write_shader(hetab_context *ctx, const request *r) {
  HETAB_ENDS(hetab_surface_end) hetab_surface *surface = NULL;
  HETAB_FREED char *text = NULL;
  if (r->output && !cli_output_allowed(ctx, r->output, r->force))
    return CLI_FAILURE;
  int status = CLI_OK;
  if ((r->surface && hetab_surface_open(ctx, r->surface, &surface) != HETAB_OK) ||
      hetab_shader_text(ctx, surface, (hetab_shader_language)r->language, &text) != HETAB_OK)
    status = cli_fail_context(ctx);
  else
    status = save(ctx, r, text);
  return status;
}

static int run(const cli_command *self, int argc, char **argv) {
  request r = {.language = -1};
  const cli_option options[] = {
      {CLI_CHOICE, "language", 'l', "c|glsl|python|mitsuba",
       "python: numpy; mitsuba: Python with the material he_torrance for Mitsuba 3", &r.language, 0,
       0},
      {CLI_TEXT, "output", 'o', "FILE", "where to write; without it, standard output", &r.output, 0,
       0},
      CLI_FORCE(&r.force),
      {0},
  };
  int status = cli_parse_operand(self, options, argc, argv, NULL, &r.surface);
  if (status >= 0)
    return status;
  if (r.language < 0)
    return cli_usage(self, "no --language given: c, glsl, python or mitsuba");
  HETAB_ENDS(hetab_context_end) hetab_context *ctx = cli_context();
  status = ctx ? write_shader(ctx, &r) : CLI_FAILURE;
  return status;
}

const cli_command cli_shader = {
    .name = "shader",
    .arguments = "[SURFACE] --language LANGUAGE",
    .summary = "the model as source: shaders, C, Python, Mitsuba 3",
    .description =
        "Writes one self-contained file with the model in it: f_dd, the delta's reflectance rho_s, "
        "f_ud, sampling and its density, with all parameters free. The series is in it as a "
        "table of 17 KB that serves every surface, whose measured error stands in the head.\n\n"
        "With SURFACE (a preset, see 'hetab surfaces', or a YAML file) its numbers are in the file "
        "too.",
    .run = run,
};
