/* The specular delta as a lobe that a MERL table can hold: constant over a cone of half vectors,
 * with the delta's energy. */
#ifndef HETAB_ENGINE_SPECULAR_CONE_H
#define HETAB_ENGINE_SPECULAR_CONE_H

/* theta_h rows of the table that a cone of that half-angle about the normal fills, at least one; 0
 * if it is 0. Whole rows, so that the energy is the reader's, who does not interpolate. */
int hetab_specular_cone_rows(double cone);

/* The BRDF over the first `rows` theta_h rows that reflects all light incident at theta:
 * 1 / integral over the cone of 4 (i.h) cos(theta_r) dh, half vectors whose mirror direction is
 * below the horizon left out. 1/sr. Energy error: tests/test_merl.c. */
double hetab_specular_cone_lobe(double theta, int rows);

#endif
