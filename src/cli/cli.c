#include "cli.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "core/printable.h"
#include "progress.h"
#include "signals.h"

/* One line on standard error, in one write. What fails because of an earlier failure stays silent:
 * there is never a second line. */
static void print_line(const char *format, va_list args, const char *tail) {
  static int printed;
  if (printed++)
    return;
  char line[2048] = "hetab: ";
  size_t head = strlen(line);
  vsnprintf(line + head, sizeof line - head - 1, format, args);
  strncat(line, tail, sizeof line - strlen(line) - 2);
  hetab_make_printable(&(hetab_printable){0}, line, strlen(line), "");
  strcat(line, "\n");
  cli_progress_end();
  fputs(line, stderr);
}

static void print_simple(const char *format, ...) {
  va_list args;
  va_start(args, format);
  print_line(format, args, "");
  va_end(args);
}

static int fail_signal(void) {
  int number = cli_signal();
  print_simple("stopped by SIG%s", sigabbrev_np(number));
  return 128 + number;
}

int cli_fail(const char *format, ...) {
  if (cli_signal())
    return fail_signal();
  va_list args;
  va_start(args, format);
  print_line(format, args, "");
  va_end(args);
  return CLI_FAILURE;
}

int cli_fail_context(const hetab_context *ctx) {
  return cli_fail("%s", hetab_error_message(ctx));
}

int cli_usage(const cli_command *self, const char *format, ...) {
  char tail[64];
  snprintf(tail, sizeof tail, ". Try 'hetab%s%s --help'.", self ? " " : "", self ? self->name : "");
  va_list args;
  va_start(args, format);
  print_line(format, args, tail);
  va_end(args);
  return CLI_USAGE;
}

hetab_context *cli_context(void) {
  hetab_context *ctx;
  if (hetab_context_create(&ctx) != HETAB_OK) {
    cli_fail("out of memory");
    return NULL;
  }
  cli_progress_watch(ctx);
  hetab_keep_inputs(ctx);
  if (hetab_outputs_begin(ctx) == HETAB_OK)
    return ctx;
  cli_fail_context(ctx);
  hetab_context_free(ctx);
  return NULL;
}

int cli_publish(hetab_context *ctx) {
  if (cli_signal())
    return fail_signal();
  return hetab_outputs_publish(ctx) == HETAB_OK ? -1 : cli_fail_context(ctx);
}

int cli_finish_output(int status) {
  if (cli_signal()) /* too late to stop anything, but the shell's loop has to know */
    return fail_signal();
  errno = 0;
  int failed = fflush(stdout) | ferror(stdout);
  if (!failed || (status != CLI_OK && status != CLI_CHECK_FAILED))
    return status;
  if (!errno) /* an earlier write failed, and its reason is forgotten: the descriptor tells again */
    (void)!write(STDOUT_FILENO, "\n", 1);
  if (errno == EPIPE) /* with SIGPIPE ignored: the reader went away, which needs no words */
    return CLI_FAILURE;
  return cli_fail("standard output: %s", errno ? strerror(errno) : "write error");
}
