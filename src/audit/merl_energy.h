/* Energy of a MERL table. */
#ifndef HETAB_AUDIT_MERL_ENERGY_H
#define HETAB_AUDIT_MERL_ENERGY_H

#include <hetab/audit.h>
#include <hetab/merl.h>

/* rho[3] = integral over the hemisphere of the looked-up table times cos(theta_r), for light from
 * theta_i (radians). The midpoint rule in the half vector, refined until two levels agree to
 * `tolerance` (absolute) in every channel, or a limit is reached; error[3] says how well. */
void hetab_merl_energy(const hetab_merl *merl, hetab_reading lookup, double theta_i,
                       double tolerance, double rho[3], double error[3]);

#endif
