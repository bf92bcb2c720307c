/* Text that a terminal may show: names come from files, and may hold what drives one. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* Where in a character of UTF-8 the text before ended; zeroed at its start. */
typedef struct hetab_printable {
  int rest;
  bool is_c1; /* U+0080 to U+00BF */
} hetab_printable;

/* Control characters (C0 but `kept`, DEL, C1) and what is no UTF-8 become '?', in place. */
void hetab_make_printable(hetab_printable *state, char *text, size_t size, const char *kept);
