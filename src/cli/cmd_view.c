/* hetab view: pictures of a surface or of a table. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "cli.h"
#include "options.h"
#include "numbers.h"
#include "output.h"

typedef struct request {
  const char *input, *output, *theta_i, *wavelength, *device;
  int what, nearest, force, quiet, json;
  size_t size;
  double exposure;
} request;

typedef hetab_status (*save_fn)(hetab_context *ctx, const hetab_view *view, const char *path,
                                int overwrite);

typedef struct view_job {
  const request *request;
  hetab_context *ctx;
  hetab_grid *grid;
  hetab_surface *surface;
  hetab_engine *engine;
  hetab_lookup *table;
  hetab_view_options options;
  hetab_view *view;
  char *page; /* of .html */
} view_job;

/* ---- what goes where ----------------------------------------------------------------------- */

static int ends_in(const char *path, const char *ending) {
  const char *dot = strrchr(path, '.');
  return dot && dot > path && dot[-1] != '/' && strcasecmp(dot, ending) == 0;
}

/* A page, unless the name asks for OpenEXR; NULL: for neither. */
static save_fn find_format(const char *path) {
  hetab_format format;
  if (hetab_format_by_ending(path, &format))
    return format == HETAB_FORMAT_EXR ? hetab_view_save_exr : NULL;
  return ends_in(path, ".png") ? hetab_view_save_png : NULL;
}

/* Tables are told apart from surfaces by their names, and from each other by their content. */
static int is_table(const char *input) {
  hetab_format format;
  return hetab_format_by_ending(input, &format) && format != HETAB_FORMAT_EXR;
}

/* The page on which the model is explored: no picture, but another kind of output. */
static int is_explorer(const request *r) {
  return ends_in(r->output, ".html");
}

static int plan(const cli_command *self, view_job *job) {
  const request *r = job->request;
  hetab_view_options *o = &job->options;
  *o = (hetab_view_options){
      .what = (hetab_view_what)r->what, .width = r->size, .exposure = r->exposure};
  if (!r->output)
    return cli_usage(self, "no output given: use -o FILE.png, FILE.exr or FILE.html");
  if (!find_format(r->output) && !is_explorer(r))
    return cli_usage(self, "%s: the name of an output ends in .png, .exr or .html", r->output);
  if (is_explorer(r) && is_table(r->input))
    return cli_usage(self, "%s: an .html explores the model of a SURFACE, not a table", r->output);
  if (r->wavelength && cli_wavelength_list(r->wavelength, &o->wavelength_um, 1) != 1)
    return cli_usage(self, "--wavelength: '%s' is not one wavelength in nm", r->wavelength);
  return -1;
}

/* ---- the view ------------------------------------------------------------------------------ */

static hetab_status take_theta_i(view_job *job) {
  if (!job->request->theta_i)
    return HETAB_OK;
  hetab_status status = hetab_grid_create(job->ctx, &job->grid);
  if (status == HETAB_OK)
    status = hetab_grid_set_axis(job->ctx, job->grid, HETAB_THETA_I, job->request->theta_i);
  if (status != HETAB_OK)
    return status;
  job->options.theta_i = hetab_grid_radians(job->grid, HETAB_THETA_I);
  job->options.theta_i_count = hetab_grid_count(job->grid, HETAB_THETA_I);
  return HETAB_OK;
}

static hetab_status view_surface(view_job *job) {
  hetab_engine_options options = {.devices = job->request->device, .method = HETAB_METHOD_SERIES};
  hetab_status status = hetab_surface_open(job->ctx, job->request->input, &job->surface);
  if (status == HETAB_OK)
    status = hetab_engine_create(job->ctx, &options, &job->engine);
  return status == HETAB_OK
             ? hetab_view_surface(job->ctx, job->engine, job->surface, &job->options, &job->view)
             : status;
}

static hetab_status view_table(view_job *job) {
  const char *slash = strrchr(job->request->input, '/');
  hetab_lookup_rule rule = job->request->nearest ? HETAB_LOOKUP_NEAREST : HETAB_LOOKUP_INTERPOLATE;
  hetab_status status = hetab_lookup_open(job->ctx, job->request->input, rule, &job->table);
  if (status != HETAB_OK)
    return status;
  return hetab_view_table(job->ctx, job->table, slash ? slash + 1 : job->request->input,
                          &job->options, &job->view);
}

static hetab_status make_explorer(view_job *job) {
  hetab_status status = hetab_surface_open(job->ctx, job->request->input, &job->surface);
  return status == HETAB_OK
             ? hetab_shader_text(job->ctx, job->surface, HETAB_SHADER_HTML, &job->page)
             : status;
}

static int make(view_job *job) {
  hetab_status status = take_theta_i(job);
  if (status == HETAB_OK)
    status = is_explorer(job->request)       ? make_explorer(job)
             : is_table(job->request->input) ? view_table(job)
                                             : view_surface(job);
  return status == HETAB_OK ? -1 : cli_fail_context(job->ctx);
}

/* ---- the command --------------------------------------------------------------------------- */

static int save(view_job *job) {
  const request *r = job->request;
  hetab_status saved =
      job->page ? hetab_text_save(job->ctx, r->output, job->page, strlen(job->page), r->force)
                : find_format(r->output)(job->ctx, job->view, r->output, r->force);
  CLI_CALL(job->ctx, saved);
  CLI_TRY(cli_publish(job->ctx));
  if (r->json)
    return cli_json_print(json_pack("{so so ss}", "input", cli_json_text(r->input), "file",
                                    cli_json_text(r->output), "version", hetab_version()));
  if (!r->quiet)
    printf("%s\n", r->output);
  return CLI_OK;
}

static int run_request(const cli_command *self, const request *r) {
  view_job job = {.request = r};
  int status = plan(self, &job);
  if (status < 0)
    status = (job.ctx = cli_context()) ? -1 : CLI_FAILURE;
  if (status < 0 && !cli_output_allowed(job.ctx, r->output, r->force))
    status = CLI_FAILURE;
  if (status < 0)
    status = make(&job);
  if (status < 0)
    status = save(&job);
  free(job.page);
  hetab_view_free(job.view);
  hetab_lookup_free(job.table);
  hetab_engine_free(job.engine);
  hetab_surface_free(job.surface);
  hetab_grid_free(job.grid);
  hetab_context_free(job.ctx);
  return status;
}

static int run(const cli_command *self, int argc, char **argv) {
  request r = {0};
  const cli_option options[] = {
      {CLI_TEXT, "output", 'o', "FILE",
       "the picture: a page (.png), linear data (.exr), or an explorer (.html)", &r.output, 0, 0},
      {CLI_CHOICE, "what", 0, "all|lobes|maps|sphere", "what to show (all)", &r.what, 0, 0},
      {CLI_TEXT, "theta-i", 0, "SPEC",
       "up to four incident polar angles in degrees: a list, or start:stop:count (0,30,60,80)",
       &r.theta_i, 0, 0},
      {CLI_TEXT, "wavelength", 0, "NM", "one wavelength instead of colour under D65", &r.wavelength,
       0, 0},
      {CLI_COUNT, "size", 0, "PIXELS", "width of the page (1280)", &r.size, 640, 8192},
      {CLI_NUMBER, "exposure", 0, "STOPS", "brighten or darken the sphere on the page (0)",
       &r.exposure, -20, 20},
      {CLI_FLAG, "nearest", 0, NULL, "show a table's own numbers, not what is between them",
       &r.nearest, 0, 0},
      CLI_DEVICE(&r.device),
      CLI_FORCE(&r.force),
      CLI_QUIET(&r.quiet),
      {CLI_FLAG, "json", 0, NULL, "print {input, file, version}", &r.json, 0, 0},
      {0},
  };
  CLI_TRY(cli_parse_operand(self, options, argc, argv, "SURFACE or FILE", &r.input));
  return run_request(self, &r);
}

const cli_command cli_view = {
    .name = "view",
    .arguments = "SURFACE|FILE -o PICTURE",
    .summary = "pictures: lobes, maps, a lit sphere; or a page to explore",
    .description =
        "Draws SURFACE (a preset, see 'hetab surfaces', or a YAML file) or a table (.h5, .binary, "
        ".bsdf): its lobes in the plane of incidence, maps of the hemisphere of viewers on a "
        "logarithmic scale, and a sphere under two white lights and a dome, the specular delta "
        "included where it is known.\n\n"
        "A .png is one page. A .exr holds the numbers: parts sphere (radiance), "
        "map_theta_i_30_00deg and lobe_theta_i_30_00deg (1/sr) and so on, in linear sRGB, or with "
        "--wavelength the same number in R, G and B.\n\nA .html is one file that explores the "
        "model of SURFACE in a "
        "browser with WebGL 2: sliders for all parameters, a lit sphere, lobes and reflectances.",
    .run = run,
};
