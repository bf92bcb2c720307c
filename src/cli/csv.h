/* Lines and fields of a CSV stream. */
#ifndef HETAB_CLI_CSV_H
#define HETAB_CLI_CSV_H

#include <stddef.h>
#include <stdio.h>

enum { CSV_MAX_LINE = 65536 };

typedef struct csv_reader {
  FILE *stream;
  size_t line; /* number of the line last read, from 1 */
  size_t length;
  char text[CSV_MAX_LINE]; /* of that line, without its end; NUL-terminated */
} csv_reader;

typedef enum csv_status {
  CSV_OK,
  CSV_END,    /* no more lines */
  CSV_LONG,   /* the line does not fit */
  CSV_BINARY, /* the line holds a NUL byte */
  CSV_FAILED  /* the read failed: errno */
} csv_status;

/* The next line that is not blank; LF and CRLF ends, and a byte order mark, are taken off. */
csv_status csv_read(csv_reader *reader);

/* Splits line in place at its commas and returns how many fields there are (fields beyond max are
 * counted but not stored). Spaces around a field and double quotes are taken off; quoted commas and
 * doubled quotes are kept. 0: a quote is not closed. */
size_t csv_split(char *line, char **fields, size_t max);

#endif
