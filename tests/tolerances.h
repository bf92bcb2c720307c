/* Every bound of the numerical tests, in one table. */
#ifndef HETAB_TESTS_TOLERANCES_H
#define HETAB_TESTS_TOLERANCES_H
#define TOL_FLOOR 1e-9
#define TOL_BELOW_FLOOR 1e-14
#define TOL_GOLDEN_FLOAT 1e-5
#define TOL_GOLDEN_DOUBLE 1e-10
#define TOL_GX_FLOAT 1e-6
#define TOL_GX_DOUBLE 1e-13
#define TOL_FACTORS 1e-13
#define TOL_SPECULAR_FLOOR 1e-30
#define TOL_LITERAL 1e-8
#define TOL_TOTAL_FLOAT 1e-4
#endif
