/* The frame of every page that the project writes: one self-contained file, with the styles of its
 * tables and plots. */
#pragma once

#include <stdio.h>

/* Classes m0 (nothing) ... m23 colour the levels of maps. */
enum { HETAB_PAGE_LEVELS = 24 };

/* All up to and including the first heading, which is `heading` followed by `name`. */
void hetab_page_begin(FILE *out, const char *title, const char *heading, const char *name);
void hetab_page_end(FILE *out);

/* Text with what HTML reserves escaped. */
void hetab_page_text(FILE *out, const char *text);
