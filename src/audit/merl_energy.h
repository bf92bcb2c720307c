/* Energy of a MERL table. */
#pragma once

#include <hetab/audit.h>
#include <hetab/merl.h>

/* rho[3] = integral over the hemisphere of the looked-up table times cos(theta_r), for light from
 * theta_i (radians). Rings of half vectors, cut where the reader goes from cell to cell, refined
 * until error[3] <= `tolerance` (absolute), or a limit is reached. |rho - truth| <= error, and much
 * less where the table is smooth (tests/test_audit.c: 3e-6 for white). */
void hetab_merl_energy(const hetab_merl *merl, hetab_reading lookup, double theta_i,
                       double tolerance, double rho[3], double error[3]);
