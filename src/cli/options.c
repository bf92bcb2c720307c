#include "options.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "numbers.h"

enum { HELP_COLUMN = 28, WIDTH = 80 };

/* getopt's codes for options: their place in the table, out of the way of letters. */
enum { CODE_BASE = 1000, CODE_HELP = CODE_BASE + CLI_MAX_OPTIONS };

/* ---- help ---------------------------------------------------------------------------------- */

void cli_print_wrapped(const char *text, int indent, int column) {
  for (;; text++) {
    int word = (int)strcspn(text, " \n");
    if (column > indent && column + 1 + word > WIDTH) {
      putchar('\n');
      column = 0;
    }
    if (word) {
      int pad = column < indent ? indent - column : column > indent;
      printf("%*s%.*s", pad, "", word, text);
      column += pad + word;
    }
    text += word;
    if (*text != ' ') {
      putchar('\n');
      column = 0;
    }
    if (!*text)
      return;
  }
}

static void print_option(char letter, const char *name, const char *argument, const char *help) {
  char head[2 * WIDTH], flag[8] = "    ";
  if (letter)
    snprintf(flag, sizeof flag, "-%c, ", letter);
  int column = snprintf(head, sizeof head, "  %s--%s%s%s", flag, name, argument ? "=" : "",
                        argument ? argument : "");
  fputs(head, stdout);
  if (column >= HELP_COLUMN) {
    putchar('\n');
    column = 0;
  }
  cli_print_wrapped(help, HELP_COLUMN, column);
}

static void print_help(const cli_command *self, const cli_option *options) {
  printf("Usage: hetab %s [OPTION]... %s\n\n", self->name, self->arguments);
  cli_print_wrapped(self->description, 0, 0);
  puts("\nOptions:");
  for (const cli_option *o = options; o->name; o++)
    print_option(o->letter, o->name, o->argument, o->help);
  print_option(0, "help", NULL, "print this help");
}

/* ---- parsing ------------------------------------------------------------------------------- */

/* Which of "a|b|c" the word is; -1: none of them. */
static int find_choice(const char *choices, const char *word) {
  size_t length = strlen(word);
  for (int i = 0;; i++) {
    size_t span = strcspn(choices, "|");
    if (span == length && memcmp(choices, word, span) == 0)
      return i;
    if (!choices[span])
      return -1;
    choices += span + 1;
  }
}

static int parse_choice(const cli_command *self, const cli_option *o, const char *text) {
  int choice = find_choice(o->argument, text);
  if (choice < 0)
    return cli_usage(self, "--%s: '%s' is none of %s", o->name, text, o->argument);
  *(int *)o->value = choice;
  return -1;
}

static int parse_range(const cli_command *self, const cli_option *o, const char *text) {
  double number;
  if (!(o->kind == CLI_SHARE ? cli_share : cli_number)(text, &number))
    return cli_usage(self, "--%s: '%s' is not a number", o->name, text);
  if (number < o->min || number > o->max)
    return cli_usage(self, "--%s: %s is outside %.10g to %.10g%s", o->name, text, o->min, o->max,
                     o->kind == CLI_SHARE && !strchr(text, '%') ? "; 1 per cent is 0.01 or 1%"
                                                                : "");
  if (o->kind != CLI_COUNT)
    *(double *)o->value = number;
  else if (number == floor(number))
    *(size_t *)o->value = (size_t)number;
  else
    return cli_usage(self, "--%s: %s is not a whole number", o->name, text);
  return -1;
}

static int append(cli_list *list, const char *item) {
  const char **grown = realloc(list->items, (list->count + 1) * sizeof *grown);
  if (!grown)
    return cli_fail("out of memory");
  list->items = grown;
  list->items[list->count++] = item;
  return -1;
}

static int parse_value(const cli_command *self, const cli_option *o, const char *text) {
  switch (o->kind) {
  case CLI_FLAG:
    *(int *)o->value = 1;
    return -1;
  case CLI_TEXT:
    *(const char **)o->value = text;
    return -1;
  case CLI_LIST:
    return append(o->value, text);
  case CLI_CHOICE:
    return parse_choice(self, o, text);
  default:
    return parse_range(self, o, text);
  }
}

/* What getopt found wrong. It leaves the culprit in optopt: a letter, one of our codes, or 0. */
static int report_bad_option(const cli_command *self, const cli_option *options, int code,
                             char **argv) {
  const char *problem = code == ':' ? "needs an argument" : "takes no argument";
  if (optopt == CODE_HELP)
    return cli_usage(self, "option '--help' %s", problem);
  if (optopt >= CODE_BASE)
    return cli_usage(self, "option '--%s' %s", options[optopt - CODE_BASE].name, problem);
  if (optopt)
    return cli_usage(self, "%s '-%c'%s%s", code == ':' ? "option" : "unknown option", optopt,
                     code == ':' ? " " : "", code == ':' ? problem : "");
  return cli_usage(self, "unknown or ambiguous option '%s'", argv[optind - 1]);
}

static const cli_option *find_letter(const cli_option *options, int letter) {
  while (options->name && options->letter != letter)
    options++;
  return options;
}

/* The table in getopt's terms. */
static void describe(const cli_option *options, struct option *longs, char *shorts) {
  *shorts++ = ':'; /* tell a missing argument from an unknown option */
  int i = 0;
  for (; options[i].name; i++) {
    int has_argument = options[i].kind == CLI_FLAG ? no_argument : required_argument;
    longs[i] = (struct option){options[i].name, has_argument, NULL, CODE_BASE + i};
    if (options[i].letter) {
      *shorts++ = options[i].letter;
      if (has_argument)
        *shorts++ = ':';
    }
  }
  longs[i] = (struct option){"help", no_argument, NULL, CODE_HELP};
  longs[i + 1] = (struct option){0};
  *shorts = 0;
}

int cli_parse_options(const cli_command *self, const cli_option *options, int argc, char **argv,
                      int *first) {
  struct option longs[CLI_MAX_OPTIONS + 2];
  char shorts[2 * CLI_MAX_OPTIONS + 2];
  describe(options, longs, shorts);
  opterr = 0;
  optind = 0; /* 0, not 1: glibc starts afresh */
  for (int code; (code = getopt_long(argc, argv, shorts, longs, NULL)) != -1;) {
    if (code == CODE_HELP) {
      print_help(self, options);
      return CLI_OK;
    }
    if (code == '?' || code == ':')
      return report_bad_option(self, options, code, argv);
    const cli_option *o =
        code >= CODE_BASE ? &options[code - CODE_BASE] : find_letter(options, code);
    int status = parse_value(self, o, optarg);
    if (status >= 0)
      return status;
  }
  *first = optind;
  return -1;
}

int cli_parse_operand(const cli_command *self, const cli_option *options, int argc, char **argv,
                      const char *what, const char **operand) {
  int first, status = cli_parse_options(self, options, argc, argv, &first);
  if (status >= 0)
    return status;
  if (what && first == argc)
    return cli_usage(self, "no %s given", what);
  if (argc - first > 1)
    return cli_usage(self, "unexpected argument '%s'", argv[first + 1]);
  *operand = argv[first];
  return -1;
}
