/* A MERL table as a renderer looks it up, at places given in cells. */
#ifndef HETAB_AUDIT_MERL_READ_H
#define HETAB_AUDIT_MERL_READ_H

#include <hetab/audit.h>
#include <hetab/merl.h>

/* A place: cell i covers [i, i + 1). phi_d may be any number. */
typedef struct hetab_merl_place {
  double h, d, p;
} hetab_merl_place;

hetab_merl_place hetab_merl_place_of(double theta_i, double theta_r, double phi);

/* lookup is not HETAB_READ_DEFAULT. What the file marks invalid, and what is no number, is 0:
 * renderers draw it black. */
void hetab_merl_read(const hetab_merl *merl, hetab_reading lookup, hetab_merl_place place,
                     double rgb[3]);

#endif
