/* Numbers as text, always with '.' whatever the locale, and the values that a quantity may take. */
#pragma once

#include <stdbool.h>
#include "core/context.h"

/* The range of a quantity, ends included, and the words that ask for a value in it. */
typedef struct hetab_rule {
  double min, max;
  const char *wanted; /* "a length from 1e-9 to 1e6 um" */
} hetab_rule;

extern const hetab_rule hetab_rule_length; /* roughness and wavelengths, um */
extern const hetab_rule hetab_rule_slope;  /* sigma0 / tau */
extern const hetab_rule hetab_rule_n;      /* real part of the index */
extern const hetab_rule hetab_rule_k;      /* imaginary part */
/* Of rows in files of indices, which may go on far beyond what is asked of them. */
extern const hetab_rule hetab_rule_wavelength_data, hetab_rule_n_data, hetab_rule_k_data;
extern const hetab_rule hetab_rule_reflectance; /* pi * BRDF */
extern const hetab_rule hetab_rule_brdf;        /* 1/sr */
extern const hetab_rule hetab_rule_any;         /* any finite number */

/* The whole of text as one decimal number, blanks around it allowed. Hexadecimal, "nan" and "inf"
 * are no numbers here; what overflows comes out as infinity. */
bool hetab_number_parse(const char *text, double *value);

/* Whether the text is one of the spellings that programs give to a value they do not have: "",
 * "nan",
 * "-inf", "bad", "---". */
bool hetab_number_missing(const char *text);
/* A number, or NaN for such a word; false: neither. */
bool hetab_number_or_missing(const char *text, double *value);

/* Parse and check; the messages name the text and what is wanted. */
hetab_status hetab_number_read(hetab_context *ctx, const char *text, const hetab_rule *rule,
                               double *value);
hetab_status hetab_number_check(hetab_context *ctx, const hetab_rule *rule, double value);

/* The fewest digits that read back as the same double, without an exponent at everyday sizes. */
enum { HETAB_NUMBER_TEXT = 32 };
void hetab_number_format(double value, char text[HETAB_NUMBER_TEXT]);

/* Two significant digits, and from 100 on the whole number, never "1e+02": .text is for the
 * arguments of one printf. */
typedef struct hetab_digits {
  char text[12];
} hetab_digits;
hetab_digits hetab_two_digits(double value);

/* The smallest first. */
void hetab_sort(double *values, size_t count);
