/* Units of length and angle, and the names of columns that carry them, as people write them. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

typedef enum hetab_quantity { HETAB_PLAIN, HETAB_LENGTH, HETAB_ANGLE } hetab_quantity;

/* "nm", "[µm]", "Microns", "deg" in um or radians; 0: no unit of that quantity. */
double hetab_unit(hetab_quantity quantity, const char *text);

/* value in um or radians; a third of a micrometre in nm is as exact as 333 / 1000. */
double hetab_in_unit(double value, double unit);

/* Lower case, in ASCII: Greek letters by their names, accents left out. */
void hetab_plain_letters(const char *text, char *plain, size_t size);

/* Whether a column's name is one of "thetar|thetas" (see hetab_csv_wanted), and the unit that it
 * carries: "theta_r_deg", "Theta r [rad]", "x in µm", "z/mm", "lateral um"; 0: none that is known.
 * 2: it is; 1: it would be, if the rest of it were a unit; 0: it is not. */
int hetab_names_quantity(const char *name, const char *names, hetab_quantity quantity,
                         double *unit);
