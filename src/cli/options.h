/* Options as tables: one table of a command both parses its command line and writes its help. */
#pragma once

#include <stddef.h>
#include "cli.h"

enum { CLI_MAX_OPTIONS = 32 }; /* of a table */

typedef enum cli_kind {
  CLI_FLAG,   /* int: 1 if given */
  CLI_TEXT,   /* const char * */
  CLI_LIST,   /* cli_list: may be given several times */
  CLI_NUMBER, /* double in [min, max] */
  CLI_SHARE,  /* likewise, "3.9%" being 0.039 */
  CLI_COUNT,  /* size_t in [min, max] */
  CLI_CHOICE  /* int: which of the words "a|b|c" that `argument` lists */
} cli_kind;

typedef struct cli_list {
  const char **items; /* free() it */
  size_t count;
} cli_list;

typedef struct cli_option {
  cli_kind kind;
  const char *name;
  char letter;          /* 0: none */
  const char *argument; /* the argument's name in the help; NULL for a flag */
  const char *help;
  void *value;     /* where the value goes; keeps its default if the option is absent */
  double min, max; /* of numbers and counts */
} cli_option;

/* Parses argv by the table (which ends with a NULL name) and adds --help. Returns -1 to go on, with
 * the positional arguments in argv[*first .. argc); else the exit status: help was printed, or the
 * one line of a usage error. */
int cli_parse_options(const cli_command *self, const cli_option *options, int argc, char **argv,
                      int *first);

/* The same of a command with one operand: *operand, NULL if there is none, which is an error where
 * `what` names it. */
int cli_parse_operand(const cli_command *self, const cli_option *options, int argc, char **argv,
                      const char *what, const char **operand);

/* Options that commands share: rows of their tables. */
#define CLI_DEVICE(value)                                                                          \
  {                                                                                                \
    CLI_TEXT, "device", 0, "SEL", "number or part of the name of a device ('hetab devices')",      \
        value, 0, 0                                                                                \
  }
#define CLI_PRECISION(value)                                                                       \
  { CLI_CHOICE, "precision", 0, "float|double", "arithmetic on the device (float)", value, 0, 0 }
#define CLI_FORCE(value)                                                                           \
  { CLI_FLAG, "force", 'f', NULL, "overwrite existing files", value, 0, 0 }
#define CLI_QUIET(value)                                                                           \
  { CLI_FLAG, "quiet", 'q', NULL, "print neither results nor progress", value, 0, 0 }

/* Text after `indent` columns, wrapped at 80; a newline starts a new line. */
void cli_print_wrapped(const char *text, int indent, int column);
