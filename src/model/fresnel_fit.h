/* Polynomials of what Fresnel's equations need, for kernels/fresnel.h. */
#pragma once

/* fit[2 * HETAB_FRESNEL_FIT]: a = Re sqrt((n + ik)^2 - sin^2) and m = |(n + ik)^2 - sin^2| as
 * polynomials in 2 cos^2 - 1. How many coefficients each has: HETAB_FRESNEL_SHORT or
 * HETAB_FRESNEL_FIT, so that the Fresnel reflectance made of them is within `tolerance`, relative,
 * at all angles; 0 if neither is: then they must not be used. */
int hetab_fresnel_fit(double n, double k, double tolerance, double *fit);
