/* hetab: the program. Finds the command and runs it; each command has a file of its own. */
#include <fcntl.h>
#include <locale.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "output.h"
#include "signals.h"
#include "terminal.h"

static const cli_command *const commands[] = {
    &cli_tabulate,  &cli_plan,    &cli_batch,    &cli_convert,     &cli_view,
    &cli_eval,      &cli_devices, &cli_surfaces, &cli_reflectance, &cli_audit,
    &cli_roughness, &cli_fit,     &cli_predict,  &cli_bench,       &cli_shader};
static const size_t command_count = sizeof commands / sizeof *commands;

static int print_help(void) {
  puts("Usage: hetab COMMAND [OPTION]... [ARGUMENT]...\n\n"
       "Tabulates the He-Torrance reflectance model for renderers, on OpenCL devices,\n"
       "with a measured error.\n\nCommands:");
  for (size_t i = 0; i < command_count; i++)
    printf("  %-12s %s\n", commands[i]->name, commands[i]->summary);
  puts("\n'hetab COMMAND --help' describes a command, 'hetab --version' prints the version.\n\n"
       "Exit status: 0 success, 1 failure, 2 mistake on the command line, 3 an audit's check\n"
       "failed, 128 + N stopped by signal N.\n\n"
       "Example:\n"
       "  hetab tabulate BBQAL2 -o bbqal2.h5 -o bbqal2.binary");
  return CLI_OK;
}

static int print_version(void) {
  printf("hetab %s\n", hetab_version());
  return CLI_OK;
}

static const cli_command *find_command(const char *name) {
  for (size_t i = 0; i < command_count; i++)
    if (strcmp(commands[i]->name, name) == 0)
      return commands[i];
  return NULL;
}

static int run(int argc, char **argv) {
  if (argc < 2)
    return cli_usage(NULL, "no command given");
  if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)
    return print_help();
  if (strcmp(argv[1], "--version") == 0)
    return print_version();
  const cli_command *command = find_command(argv[1]);
  if (!command)
    return cli_usage(NULL, "unknown %s '%s'", argv[1][0] == '-' ? "option" : "command", argv[1]);
  return command->run(command, argc - 1, argv + 1);
}

/* A closed standard descriptor must not become the number of an output file. The substitute is
 * open in the wrong direction, so that using it still fails. */
static void fill_standard_descriptors(void) {
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
    if (fcntl(fd, F_GETFD) == -1)
      (void)!open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

int main(int argc, char **argv) {
  fill_standard_descriptors();
  /* Numbers read and written have a decimal point whatever a device driver does to the locale. */
  uselocale(newlocale(LC_ALL_MASK, "C", NULL));
  cli_catch_signals();
  cli_guard_terminal();
  cli_json_begin();
  return cli_finish_output(run(argc, argv));
}
