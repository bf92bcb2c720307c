/* The plain data that several parts of the library share, and the words for its enumerations. */
#pragma once

#include <stddef.h>
#include <hetab/status.h>

HETAB_BEGIN

typedef enum hetab_precision { HETAB_FLOAT, HETAB_DOUBLE } hetab_precision;

typedef enum hetab_method {
  HETAB_METHOD_ROWS,   /* polynomials of the series, made by the host to the tolerance */
  HETAB_METHOD_SERIES, /* the constant-cost series at every entry */
  HETAB_METHOD_LITERAL /* the printed equations in double on one host core, no device */
} hetab_method;

typedef enum hetab_format {
  HETAB_FORMAT_H5,
  HETAB_FORMAT_MERL,
  HETAB_FORMAT_RGL,
  HETAB_FORMAT_EXR /* written, not read */
} hetab_format;

const char *hetab_method_name(hetab_method method);          /* "rows" */
const char *hetab_precision_name(hetab_precision precision); /* "float" */

/* What the surface is at one wavelength. */
typedef struct hetab_band {
  double lambda_um;    /* vacuum wavelength, um */
  double n, k;         /* refractive index */
  double diffuse_brdf; /* uniform-diffuse term `a` of Eq. 9, 1/sr */
} hetab_band;

/* A pair of directions by its angles, radians from the normal; phi is the viewer's azimuth minus
 * the light's. (Renderers' calls take unit vectors away from the surface, the normal being z.) */
typedef struct hetab_directions {
  double theta_i, theta_r, phi;
} hetab_directions;

/* One evaluation: everything that the model depends on. Angles in radians. */
typedef struct hetab_point {
  double lambda_um;        /* > 0 */
  double theta_i, theta_r; /* [0, pi/2] */
  double phi;              /* any finite azimuth */
  double sigma0_um;        /* > 0 */
  double tau_um;           /* > 0 */
  double n, k;             /* n > 0, k >= 0 */
  double diffuse_brdf;     /* >= 0, 1/sr */
} hetab_point;

typedef struct hetab_value {
  double dd;       /* directional-diffuse BRDF, Eq. 8, 1/sr */
  double specular; /* specular reflectance rho_s(theta_i), Eq. 10, dimensionless */
  double ud;       /* uniform-diffuse BRDF, Eq. 9, 1/sr */
  double total;    /* dd + ud, 1/sr: what tables hold (the specular delta is apart) */
  double g;        /* roughness phase parameter, Eq. 19 */
  double x;        /* v_xy^2 tau^2 / 4 */
} hetab_value;

/* A part of a dense table: some theta_i rows of one wavelength. values[theta_i][theta_r][phi],
 * phi fastest; float or double as the engine's precision. dd + ud in 1/sr, no cosine. */
typedef struct hetab_slab {
  size_t wavelength;
  size_t theta_i_first, theta_i_count;
  const void *values;
} hetab_slab;

/* Receives slabs from the calling thread, in any order, each once. Not HETAB_OK stops the job. */
typedef hetab_status (*hetab_slab_fn)(hetab_context *ctx, void *user, const hetab_slab *slab);

/* Relative error over sampled entries with reference >= 1e-9 / sr; absolute error below. max_rel is
 * the largest in the sample, not a bound: see hetab_error_share_above(). */
typedef struct hetab_error_stats {
  size_t samples;                   /* entries compared in all */
  size_t compared;                  /* of them with reference >= 1e-9 / sr */
  double max_rel, p99_rel, rms_rel; /* over `compared` */
  double max_abs_below;             /* over the others, 1/sr */
  size_t bad;                       /* NaN, infinite or negative entries (none, ever) */
} hetab_error_stats;

/* The share of all entries above 1e-9 / sr that may exceed max_rel, at 95 %: 3 / compared (a share
 * p would have missed the sample with a probability of e^-(p compared)); 1: nothing was compared.
 */
double hetab_error_share_above(const hetab_error_stats *error);

typedef struct hetab_report {
  double entries;          /* spectral entries evaluated */
  double kernel_seconds;   /* running kernels and what they wait for, summed over devices */
  double wall_seconds;     /* whole call, the sink included */
  hetab_error_stats error; /* against the literal reference, on a random sample */
  size_t clamped;          /* MERL: cells with a negative linear sRGB value, set to 0 */
  hetab_method method;     /* how it was made: of the engine */
  hetab_precision precision;
  double tolerance;
  char device[512]; /* the devices that took part, in words */
} hetab_report;

HETAB_END
