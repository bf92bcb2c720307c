/* Delimited text: the one reader of tables that people and instruments write.
 *
 * A table is a header of names, perhaps a row of units below it, and rows of fields; above it may
 * stand lines of anything else. Text is UTF-8, UTF-16 with its mark, or Latin-1; fields are
 * separated by ';', tab, ',' or blanks, whichever the file uses, and may be in double quotes; '#'
 * starts a comment; the decimal mark is a comma where that is the only reading. Lines are counted
 * from 1, and every message begins with "FILE:LINE: ". */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include "core/context.h"
#include "core/number.h"
#include "core/unit.h"

/* A column to look for: names in lower case, letters and digits only, without their unit:
 * "theta_i_deg" and "Theta i [rad]" are "thetai". "z#": digits may follow; "pos*": anything may. */
typedef struct hetab_csv_wanted {
  const char *names; /* "thetar|thetas" */
  hetab_quantity quantity;
} hetab_csv_wanted;

enum { HETAB_CSV_OTHER = -1 }; /* a column that nobody asked for */
#define HETAB_CSV_ABSENT SIZE_MAX

typedef struct hetab_csv_column {
  char *name;  /* as it is in the file */
  int wanted;  /* which of those looked for, or HETAB_CSV_OTHER */
  double unit; /* um or radians; 0: none that is known */
  hetab_quantity quantity;
  bool strange; /* something stands where the unit should */
} hetab_csv_column;

typedef struct hetab_csv {
  hetab_context *ctx;
  const char *path;
  size_t line;      /* of the line at hand, from 1; 0: none yet */
  char *content;    /* of that line; NULL at the end */
  char **field;     /* [count] of the row at hand */
  size_t count;     /* 0 at the end */
  char separator;   /* 0: not known yet */
  char decimal;     /* '.' or ','; 0: not known yet. May be set by the caller, before the header */
  bool ragged;      /* rows may have fewer fields than the header; set by the caller */
  bool named;       /* there is a header; else the columns are called "1", "2" ... */
  size_t columns;   /* 0: no table was found */
  size_t head_line; /* of the header */
  hetab_csv_column *column;
  /* its own */
  char *owned, *line_text, *work;
  const char *text, *next, *body;
  FILE *stream;
  size_t line_room, work_room, field_room;
} hetab_csv;

/* A file of at most that many bytes; a text, NUL-terminated, which has to stay; or a stream, read
 * line by line (UTF-8, lines up to 65535 bytes, the header being its first line). */
hetab_status hetab_csv_open(hetab_context *ctx, const char *path, size_t most_bytes,
                            hetab_csv *csv);
void hetab_csv_of_text(hetab_context *ctx, const char *path, const char *text, hetab_csv *csv);
void hetab_csv_of_stream(hetab_context *ctx, const char *path, FILE *stream, hetab_csv *csv);
void hetab_csv_clear(hetab_csv *csv);

/* The next line that is neither blank nor a comment, to csv->content. */
hetab_status hetab_csv_line(hetab_csv *csv);

/* Finds the header: the line, numbers below it, that names at least one of the wanted columns. If
 * there is none, the rows start where the numbers do. Without anything wanted, and of a stream, it
 * is the first line. */
hetab_status hetab_csv_header(hetab_csv *csv, const hetab_csv_wanted *wanted, size_t count);
/* The same of a header that stands in the text given (of the line at hand). */
hetab_status hetab_csv_names(hetab_csv *csv, char *names, const hetab_csv_wanted *wanted,
                             size_t count);
/* The column that is wanted[which], or HETAB_CSV_ABSENT; an error if there are two, or if it has no
 * unit where it needs one: `example` is how it should be named. */
hetab_status hetab_csv_find(hetab_csv *csv, int which, const char *example, size_t *column);

/* The next row, to field[count], of as many fields as the header has; empty ones beyond it are
 * passed over. */
hetab_status hetab_csv_row(hetab_csv *csv);
/* Likewise of the line at hand. */
hetab_status hetab_csv_fields(hetab_csv *csv);

/* The number in a field of the row, in um, radians or as it is; `rule` is for what comes out. */
hetab_status hetab_csv_number(hetab_csv *csv, size_t column, const hetab_rule *rule, double *value);
/* Likewise any number, or NaN for the words that stand for a value that is missing. */
hetab_status hetab_csv_value(hetab_csv *csv, size_t column, double *value);
/* The whole of a text as a number with this file's decimal mark, NaN where it stands for one that
 * is missing; false for anything else. */
bool hetab_csv_parse(hetab_csv *csv, const char *text, double *value);

/* The fields of the line at hand, to field[count]. */
hetab_status hetab_csv_split(hetab_csv *csv, char separator);

/* What follows one of the keys "width|breite" at the start of a line (comments too) above the rows,
 * in lower case and ASCII; false if there is none. */
bool hetab_csv_above(const hetab_csv *csv, const char *keys, char *value, size_t size);

/* Whether the text is a number and nothing else, in the file's decimals as far as they are known.
 */
bool hetab_csv_is_number(const hetab_csv *csv, const char *text);
void hetab_csv_forget_header(hetab_csv *csv);

/* HETAB_ERR_PARSE with "FILE:LINE: " before the message. */
hetab_status hetab_csv_fail(const hetab_csv *csv, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
