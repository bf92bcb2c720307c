/* What every command of the program shares: commands, exit statuses and failures. */
#pragma once

#include <hetab/hetab.h>
#include "core/scope.h"

/* A step of a command: -1 to go on, else the exit status, which ends the function. */
#define CLI_TRY(step)                                                                              \
  do {                                                                                             \
    int try_status_ = (step);                                                                      \
    if (try_status_ >= 0)                                                                          \
      return try_status_;                                                                          \
  } while (0)
/* A call of the library as a step. */
#define CLI_CALL(ctx, call) CLI_TRY((call) == HETAB_OK ? -1 : cli_fail_context(ctx))

HETAB_HANDLE(hetab_context)
HETAB_HANDLE(hetab_engine)
HETAB_HANDLE(hetab_plan)
HETAB_HANDLE(hetab_published)
HETAB_HANDLE(hetab_scene)
HETAB_HANDLE(hetab_surface)

enum { CLI_OK = 0, CLI_FAILURE = 1, CLI_USAGE = 2, CLI_CHECK_FAILED = 3 };

typedef struct cli_command {
  const char *name;
  const char *arguments;   /* as in the usage line */
  const char *summary;     /* one line of `hetab --help` */
  const char *description; /* paragraphs of `hetab COMMAND --help` */
  int (*run)(const struct cli_command *self, int argc, char **argv);
} cli_command;

extern const cli_command cli_tabulate, cli_eval, cli_devices, cli_surfaces, cli_bench, cli_shader,
    cli_reflectance, cli_audit, cli_roughness, cli_fit, cli_predict, cli_convert, cli_view,
    cli_plan, cli_batch;

/* Print the one line that a failure is, "hetab: MESSAGE", control characters made harmless, and
 * return the exit status. A pending signal wins: the line names it, the status is 128 + signal. */
int cli_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* The same for what the context's last failure says. */
int cli_fail_context(const hetab_context *ctx);
/* A mistake on the command line: the line ends in "Try 'hetab COMMAND --help'."; self may be NULL.
 */
int cli_usage(const cli_command *self, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* A context whose outputs are kept back until cli_publish() and are never its inputs; NULL after
 * printing why not. */
hetab_context *cli_context(void);
/* All that was saved gets its name, or none: -1 to go on, else the exit status after printing why.
 */
int cli_publish(hetab_context *ctx);

/* Standard output is complete; if it is not (a full disk, say), the failure is printed. */
int cli_finish_output(int status);
