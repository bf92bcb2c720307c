/* Every bound of the numerical tests, in one table: the bound, the worst measured (PoCL, x86-64,
 * AVX-512), and why it is not smaller. */
#ifndef HETAB_TESTS_TOLERANCES_H
#define HETAB_TESTS_TOLERANCES_H

/* --- Floor of the relative error, design section 6 --- */
/* 1/sr; below it errors are absolute */
#define TOL_FLOOR 1e-9

/* --- Contract of the issue: golden points, tables, hard cases --- */
/* measured 5.4e-15; 1/sr; tables store 0 below 5e-15 */
#define TOL_BELOW_FLOOR 1e-14
/* measured 5.6e-6 (rho_s 1e-30), dd 2.7e-6, hard cases 3.3e-6; exp(-g) has the error of g, at g =
 * 70 */
#define TOL_GOLDEN_FLOAT 1e-5
/* measured dd 1.4e-14, rho_s 1.4e-13 */
#define TOL_GOLDEN_DOUBLE 1e-12
/* measured 8.0e-6 (BBQAL2), hard surfaces 5.6e-6; a fifth for the atlas, the rest float
 * arithmetic */
#define TOL_TABLE_FLOAT 1e-5
/* measured 2.4e-11; what is asked of the rows method */
#define TOL_TABLE_DOUBLE 1e-9
/* measured 6.8e-39; floats underflow soon after; below it absolute */
#define TOL_SPECULAR_FLOOR 1e-30

/* --- Quantities on the way --- */
/* measured 1.6e-7; a few roundings */
#define TOL_GX_FLOAT 1e-6
/* measured 1.4e-15 */
#define TOL_GX_DOUBLE 1e-13
/* measured 6.1e-16; |F|^2, S, sigma/sigma0 on the host; a few roundings */
#define TOL_FACTORS 1e-14
/* measured 3.2e-5; indices below 1: total reflection starts with a square root of what float
 * rounds */
#define TOL_TOTAL_FLOAT 5e-5
/* measured 4.4e-3, 1.2e-9 (from 1e-12 on); within 0.01 degrees of the critical angle: the root of
 * a cancellation, half of the digits */
#define TOL_CRITICAL_FLOAT 6e-3
#define TOL_CRITICAL_DOUBLE 3e-7

/* --- The literal reference: g up to 1e6 costs digits in m ln g - g - lgamma(m + 1) --- */
/* measured 3.4e-9 (g = 1e6), 9.2e-12 (g <= 5000) */
#define TOL_LITERAL 1e-8
/* measured 1.3e-9 (steep) */
#define TOL_LITERAL_GOLDEN 1e-8
/* measured 7.8e-14; v is a sum of rounded directions */
#define TOL_LITERAL_GX 1e-12
/* measured 7.6e-14; its brackets are formed one after the other */
#define TOL_LITERAL_SYMMETRY 1e-12

/* --- Symmetries and limits of the device --- */
/* measured 7.9e-13; phi + 2 pi rounds phi: x moves by x times 1e-15 */
#define TOL_TURN 1e-11
/* measured 0; ratios are formed in double and rounded once */
#define TOL_SCALE_FLOAT 2e-6
/* measured 1.7e-14; exp(-x/m) has the error of x/m */
#define TOL_SCALE_DOUBLE 1e-12
/* measured 1.0; the first correction of the asymptote, times g */
#define TOL_BECKMANN_G 2
/* measured 0.97; 1 - e^-g over g */
#define TOL_SMOOTH_G 2

/* --- Functions of the kernels, double: against 50 digits and device against host --- */
/* measured 7.0e-15; l - ln(w) rounds with |l| <= 80 */
#define TOL_LAMBERT_DOUBLE 1e-14
/* measured 5.1e-16, 2.0e-15 device */
#define TOL_FRESNEL_DOUBLE 1e-14
/* measured 4.1e-16 */
#define TOL_SHADOW_DOUBLE 1e-14
/* measured 3.9e-14; erfc(u) has 2 u^2 times the error of u */
#define TOL_K_DOUBLE 1e-12
/* measured 1.4e-14 at 26 points, 2.5e-15 device */
#define TOL_H_DOUBLE 1e-13
/* measured 1.0e-14; its series ends at v^20 / 21 */
#define TOL_DEVIANCE_DOUBLE 1e-13
/* measured 8.2e-13; m = 10; the kernels ask from m ~ 13 on */
#define TOL_STIRLING_DOUBLE 1e-12
/* measured 2.2e-16 */
#define TOL_EXP_DOUBLE 1e-15
/* measured 2.8e-16 */
#define TOL_RATIO2_DOUBLE 1e-14

/* --- Functions of the kernels, float device against double host at the same arguments --- */
/* measured 8.1e-7 */
#define TOL_LAMBERT_FLOAT 1e-6
/* measured 7.1e-7; the host forms n^2 - 1 in double */
#define TOL_FRESNEL_FLOAT 2e-6
/* measured 2.8e-7 */
#define TOL_SHADOW_FLOAT 1e-6
/* measured 2.4e-6; erfc; relative to the larger of K and 1e-6 */
#define TOL_K_FLOAT 1e-5
/* measured 2.4e-6; 10 nodes; h >= 1e-25 */
#define TOL_H_FLOAT 5e-6
/* measured 2.0e-7 */
#define TOL_DEVIANCE_FLOAT 1e-6
/* measured 8.1e-8; as kernels/vexp.h states */
#define TOL_EXP_FLOAT 1.2e-7
/* measured 2.7e-7 */
#define TOL_RATIO2_FLOAT 1e-6

/* --- MERL tables: relative to the cell's largest channel, for colour subtracts --- */
/* measured 4.9e-6 */
#define TOL_MERL_FLOAT 1e-5
/* measured 1.3e-11 */
#define TOL_MERL_DOUBLE 1e-8
/* measured 1.9e-15; three times the model's, the sRGB matrix being that large */
#define TOL_MERL_BELOW 3e-14
/* measured 0.016; half a cell of a smooth lobe */
#define TOL_LOOKUP_MEAN 0.03
/* measured 0; a lobe's top between the corners */
#define TOL_LOOKUP_OUTSIDE 0.1
/* measured 0.0044 (2 deg), 0.0004 (5 deg), to 70 degrees, by the truncating rule; 0.0094 (2 deg),
 * to 85, by look-ups */
#define TOL_CONE_ENERGY 0.01
#define TOL_CONE_TOLD 1e-3 /* both sums are sampled */

/* --- Colour --- */
/* measured 2.3e-4; Al.b and Au.r; the expected values have 4 digits, where the rest comes from is
 * not traced */
#define TOL_COLOUR 5e-4
/* measured 2.3e-4 */
#define TOL_COLOUR_FINE 5e-4
/* measured 1.0e-3; reflectance is interpolated between samples up to 10 nm apart */
#define TOL_COLOUR_UNEVEN 2e-3
/* measured 2.4e-8; the matrix has 7 digits */
#define TOL_PRIMARIES 1e-6

/* --- Time, generous for sanitizers --- */
/* measured 0.2; seconds until a cancelled job has returned */
#define TOL_CANCEL_SECONDS 5

/* --- Hemispherical reflectances --- */
/* measured 2.0e-7 against golden/reflectance.csv; the float kernel's rounding, averaged */
#define TOL_REFLECTANCE_FLOAT 3e-7
/* measured 2.4e-12 */
#define TOL_REFLECTANCE_DOUBLE 1e-11
/* measured 1.4e-13 */
#define TOL_REFLECTANCE_SPECULAR 1e-12
/* measured 3.5e-7; the brute-force sum's own error */
#define TOL_REFLECTANCE_BRUTE 1e-6
/* measured 1.3e-7; likewise */
#define TOL_REFLECTANCE_SKY 1e-6

/* --- The exact sampler --- */
/* measured 7.4e-13, against the literal equations at sampled directions */
#define TOL_SAMPLER_EVAL 1e-9
/* measured 1.3e-13; |q_i + q_r|^2 from the directions, where a needle's lobe is 1e-3 wide */
#define TOL_SAMPLER_DENSITY 1e-10
/* measured 8.1e-8; ln h by cubics between 640 knots, down to e^-90 */
#define TOL_SAMPLER_LOBE 1e-7
/* measured 3.6e-9; the nodes of the integral over m, down to e^-25 */
#define TOL_SAMPLER_TERMS 1e-8

/* --- Look-ups --- */
/* measured 2.4e-3 (NGGAL, HDF5, 75 degrees), else 1.3e-3; relative L1 over directions weighed with
 * their cosine, against the model, up to 75 degrees */
#define TOL_LOOKUP_L1 2.5e-3
/* measured 4.8e-3; the same at 80 and 85 degrees, where shadowing sets in within a cell */
#define TOL_LOOKUP_L1_GRAZING 5e-3
/* measured 4.6e-3 up to 75 degrees, 1.15e-2 beyond; the same at slope 1, whose lobe fills the
 * hemisphere */
#define TOL_LOOKUP_STEEP 5e-3
#define TOL_LOOKUP_STEEP_GRAZING 1.2e-2
/* measured 9.4e-4; of albedos, interpolated between 48 incidences */
#define TOL_LOOKUP_ALBEDO 1e-3
/* measured 3.0e-3; of the needle as a MERL table */
#define TOL_LOOKUP_ALBEDO_NEEDLE_MERL 4e-3
/* measured 9.9e-3; a lobe of 0.2 degrees among nodes that are 1 degree apart changes between
 * them */
#define TOL_LOOKUP_ALBEDO_NEEDLE_H5 1e-2
/* measured 0; how much worse than exact centres; float rounding of cells */
#define TOL_LOOKUP_CENTRES 1e-3
/* measured 5.2e-3; up to 87 degrees; relative to the larger of rho_s and 1e-6 */
#define TOL_LOOKUP_SPECULAR 6e-3
/* measured 1.1e-4; share of samples; also the test's integral of a density with steps */
#define TOL_LOOKUP_LOST 2e-4

/* --- Conversions --- */
/* measured 0.012; 5 % of noise, 3 % dead cells, nothing beyond 84 degrees */
#define TOL_CONVERT_MEASURED 0.015
/* measured 0.003; what is missing at grazing is bright */
#define TOL_CONVERT_MEASURED_BIAS 0.005

/* --- Fits of synthetic measurements, 2 % noise --- */
/* measured 4.9e-3; of the slope, relative */
#define TOL_FIT_SLOPE 5e-3
/* measured 6.7e-3; likewise, under the constraint */
#define TOL_FIT_SLOPE_CONSTRAINED 7e-3
/* measured 6.0e-3 (NGGAL, energy weights); of `a`, a reflectance */
#define TOL_FIT_DIFFUSE 6e-3
/* measured 1.1e-4; 1 / f^2 hangs on the dark tails, which are all diffuse */
#define TOL_FIT_DIFFUSE_RELATIVE 2e-4
/* measured 1.6e-8; between starts: SLSQP's steps end there */
#define TOL_FIT_STARTS 1e-7
/* measured 1.8e-9; without noise, double: the optimisers' own tolerance */
#define TOL_FIT_EXACT_DOUBLE 1e-6
/* measured 2.1e-5; without noise, float: the objective's minimum is as flat as its rounding */
#define TOL_FIT_EXACT_FLOAT 1e-4
/* of rho_dh under the bound: what the header allows */
#define TOL_FIT_CONSTRAINT 1e-5

/* --- Roughness from scans --- */
/* measured 5.0e-11, a cut-off away from the ends */
#define TOL_TRANSMISSION 1e-6
/* measured 0.64 %; of averages over 9 scans of 4000 points, 200 trials each */
#define TOL_SCAN_BIAS 0.01
/* measured 3.4 % (BBQAL2, sigma): 9 scans hold some 700 independent heights */
#define TOL_SCAN_SPREAD 0.035
/* measured 0.955; of intervals that say 95 % */
#define TOL_SCAN_COVER 0.95
/* measured 0.925; of one scan alone */
#define TOL_SCAN_COVER_ONE 0.92
/* measured 0.13 over 200 trials each */
#define TOL_CUTOFF 0.13

/* --- RGL tables --- */
/* measured 1.7e-6; two float evaluations of one rule */
#define TOL_RGL_MITSUBA 2e-6
/* measured 1.2e-4, of samples; of given directions 9.0e-7 */
#define TOL_RGL_MITSUBA_PDF 2e-4
/* measured 3.5e-5; Mitsuba's root of the quadratic cancels */
#define TOL_RGL_MITSUBA_SAMPLE 4e-5
/* measured 2.1; standard deviations of a chi-square */
#define TOL_RGL_CHI_SQUARE 4
/* measured 0.0092 and 0.0030; what tables are asked for: 1 % and a third of it */
#define TOL_RGL_L1 0.01
#define TOL_RGL_BIAS 0.0033
/* measured 0.0025; a lobe of 2 degrees, 0 to 85 degrees: the table's own bias */
#define TOL_RGL_FOLDED 0.004
/* measured 1.1e-5; float, and the universal table of h once more interpolated */
#define TOL_RGL_SOURCE_L1 2e-5
/* measured 2.1e-3; f >= 1e-3 / sr, of lobes whose top is up to 1e5 */
#define TOL_RGL_SOURCE 3e-3
/* measured 2.3e-5; what is read is normalised again; f >= 1e-3 / sr */
#define TOL_RGL_FILE 1e-4

#endif
