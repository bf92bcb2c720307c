/* Audits: does a surface or a table conserve energy, is it reciprocal, is it physical, and what of
 * that belongs to the model, the integration or the table. And repair of tables, to a new file.
 *
 * Numerical errors are kept apart from properties: `value` is what was found, `error` how well it
 * is known, and nothing is found wrong that its own error could explain. */
#pragma once

#include <stddef.h>
#include <hetab/engine.h>
#include <hetab/surface.h>
#include <hetab/tabulate.h>

HETAB_BEGIN

typedef enum hetab_audit_kind {
  HETAB_AUDIT_SURFACE,
  HETAB_AUDIT_MERL,
  HETAB_AUDIT_H5,
  HETAB_AUDIT_RGL
} hetab_audit_kind;

typedef enum hetab_verdict { HETAB_PASS, HETAB_WARN, HETAB_FAIL } hetab_verdict;

/* How a renderer reads between the entries of a table. */
typedef enum hetab_reading {
  HETAB_READ_DEFAULT,    /* what the format's readers do: MERL truncates, HDF5 interpolates */
  HETAB_READ_TRUNCATE,   /* the entry at or below; below the first one the first */
  HETAB_READ_INTERPOLATE /* linear along every axis: MERL between cell centres, over valid cells;
                              HDF5 between entries, held beyond the ends of an axis */
} hetab_reading;

/* One question and its answer. */
typedef struct hetab_check {
  const char *name; /* stable: "structure", "energy", "fresnel", "finite", "negative", "horizon",
                       "reciprocity", "isotropy", "bilateral", "specular", "grazing", "diffuse",
                       "table_error" */
  hetab_verdict verdict;
  double value;     /* what was judged */
  double error;     /* numerical uncertainty of value; 0: exact */
  double threshold; /* what value may reach */
  char detail[224]; /* in words: what value is, and where */
} hetab_check;

enum { HETAB_AUDIT_CHECKS = 16 };

/* rho_dh at one incidence and channel, and where it comes from. */
typedef struct hetab_energy {
  double dh;       /* dd + specular + ud: all that leaves */
  double error;    /* of dh; tables: of the integral over what the lookup gives */
  double dd;       /* surface: directional-diffuse; table: all that is looked up */
  double specular; /* rho_s; HDF5: as the file has it; RGL: of the .specular.csv beside; MERL: 0 */
  double ud;       /* surface: uniform-diffuse; table: 0, it is in dd */
  double fresnel;  /* the polished material's; NaN: unknown */
  double model;    /* tables with a reference: its dd + ud; else NaN */
} hetab_energy;

/* A surface at one wavelength. */
typedef struct hetab_band_audit {
  double a;      /* the diffuse number as given, in the unit it was given in */
  int a_is_brdf; /* 1: 1/sr; 0: reflectance */
  double
      max_a_brdf; /* the largest `a` (1/sr) for which rho_dh <= 1; negative: even 0 is too much */
  double max_a_reflectance; /* the same as a reflectance: pi times that */
  double max_a_fresnel; /* as reflectance, for which rho_dh stays below the polished material's */
  double dh_if_brdf, dh_if_reflectance; /* largest rho_dh if `a` is read so */
  double min, max;                      /* computed values, 1/sr; min: the smallest above 0 */
  double specular_share;                /* largest rho_s / rho_dh */
  double grazing;                       /* rho_dh / Fresnel - 1 at the last incidence */
} hetab_band_audit;

/* Entries of a table (or computed values of a surface). */
typedef struct hetab_cells {
  size_t total;
  size_t nan, infinite, negative;
  size_t invalid_above; /* MERL: marked invalid though wholly above the horizon */
  size_t valid_below;   /* MERL: not marked though wholly below it */
  double min, max;      /* finite, > 0, 1/sr */
} hetab_cells;

/* Entries that should be equal, a and b: absolute |a - b| in 1/sr; relative to the larger, where
 * that is >= 1e-9 / sr. `norm` is the antisymmetric part's share of the table, in the root mean
 * square: 0 symmetric, 1 antisymmetric (after DeYoung & Fournier, Graphics Interface 1997). */
typedef struct hetab_symmetry {
  size_t compared; /* 0: the format leaves no room to break it */
  double mean_abs, max_abs, mean_rel, max_rel, norm;
} hetab_symmetry;

/* Table against model over direction pairs, each weighted as under uniform light from and to
 * everywhere (cosine times cosine); percentiles of |error| / model over the pairs as drawn. */
typedef struct hetab_table_error {
  size_t pairs;
  double relative_l1; /* integral of |table - model| over integral of the model */
  double bias;        /* integral of table - model over integral of the model */
  double p50, p95, p99, max;
} hetab_table_error;

enum { HETAB_ERROR_BINS = 9, HETAB_ERROR_MAP = 18 };

typedef struct hetab_against {
  hetab_table_error all, on_lobe, off_lobe;    /* on: within 2 standard deviations of the mirror */
  hetab_table_error theta_i[HETAB_ERROR_BINS]; /* of 10 degrees each */
  double map[HETAB_ERROR_MAP]
            [HETAB_ERROR_MAP]; /* relative L1 by theta_i, theta_r: 5 degrees each */
  double specular_hh; /* the model's specular part of the white-sky reflectance, mean of channels */
  double specular_in_table; /* how much of it the lookup (or the file beside it) has: 0 to 1 */
  int specular_apart;       /* the file carries it beside the BRDF (HDF5) */
} hetab_against;

/* What people look at, of one channel: BRDF in the plane of incidence, and over the hemisphere on
 * Shirley and Chiu's equal-solid-angle square. */
enum { HETAB_AUDIT_VIEWS = 4, HETAB_AUDIT_LOBE = 361, HETAB_AUDIT_MAP = 64 };

typedef struct hetab_audit_view {
  double theta_i;
  double lobe[HETAB_AUDIT_LOBE];  /* at theta_r = -90 to 90 by 0.5 deg, > 0 on the mirror side */
  double model[HETAB_AUDIT_LOBE]; /* the reference's; NaN: none */
  float map[HETAB_AUDIT_MAP][HETAB_AUDIT_MAP]; /* [row][column], the mirror side to the right */
} hetab_audit_view;

typedef struct hetab_audit {
  hetab_audit_kind kind;
  char *name;               /* of the surface, or the file's path */
  double sigma0_um, tau_um; /* of the surface, or the reference; 0: unknown */
  hetab_reading lookup;     /* tables */
  unsigned long long bytes; /* tables: size of the file */
  size_t dims[4];           /* tables: as in the file, slowest first; 0: fewer; RGL: the channels */
  double specular_cone;     /* > 0: the delta is in the table as a lobe that wide, radians; its
                               `table_error`, in which the lobe counts, is no failure */
  hetab_check checks[HETAB_AUDIT_CHECKS];
  size_t check_count;
  size_t channel_count, theta_count;
  double *lambda_um;       /* [channel]; NULL: red, green, blue */
  double *theta_i;         /* [theta], radians */
  hetab_energy *energy;    /* [channel][theta] */
  hetab_band_audit *bands; /* [channel], surfaces */
  hetab_cells cells;
  hetab_symmetry reciprocity, isotropy, bilateral;
  double separability;    /* HDF5, at view_channel: the share of the sum of squares that one product
                             u(theta_i) v(theta_r, phi) holds; else NaN */
  hetab_against *against; /* NULL: none */
  hetab_audit_view *views; /* [HETAB_AUDIT_VIEWS]; NULL: not asked for */
  size_t view_channel;
} hetab_audit;

typedef struct hetab_audit_options {
  size_t size; /* of the struct; 0: of this header's */
  hetab_reading lookup;
  double tolerance;     /* of the integrals over a MERL lookup, relative to 1; 0: 1e-3 */
  double max_excess;    /* rho_dh may exceed its bounds by this much beyond the error; 0: not */
  double max_asymmetry; /* relative; 0: 1e-3; RGL: at least 0.02, in L1 */
  double max_error;     /* relative L1 against the model: FAIL above; 0: 0.25 */
  double max_missing;   /* white-sky energy of a missing specular term: WARN above; 0: 0.01 */
  const hetab_surface *against; /* tables; NULL: the parameters in the file, if it has them */
  int no_reference;             /* do not compare, even if the file has parameters */
  hetab_merl_colour colour;     /* three channels with `against`: what they are */
  double band_um[3];
  size_t pairs;  /* direction pairs of the comparison; 0: 1e6 */
  unsigned seed; /* of them */
  int views;     /* fill in `views` */
} hetab_audit_options;

/* rho_dh at 0, 1 ... 89 degrees and every wavelength; values computed at every degree. */
hetab_status hetab_audit_surface(hetab_context *ctx, hetab_engine *engine,
                                 const hetab_surface *surface, const hetab_audit_options *options,
                                 hetab_audit **out);

/* An HDF5 (spectral or linear sRGB), MERL (.binary) or RGL (.bsdf) file, told apart by its first
 * bytes. RGL tables are looked up by <hetab/lookup.h>, their energy is integrated over its samples:
 * `error` is at most 2e-3 for white and BBQAL2 (tests/test_audit.c, test_cli.sh); reciprocity is
 * judged by its L1.
 * A file that is damaged, truncated or of wrong dimensions is a finding (check "structure"), not a
 * failure; one that is no table by its first bytes nor its name is HETAB_ERR_PARSE; one that cannot
 * be read is HETAB_ERR_IO. engine is needed for a reference only; may be NULL with no_reference. */
hetab_status hetab_audit_table(hetab_context *ctx, hetab_engine *engine, const char *path,
                               const hetab_audit_options *options, hetab_audit **out);

void hetab_audit_free(hetab_audit *audit);

/* The worst verdict of its checks, and one of them by name (NULL: not asked). */
hetab_verdict hetab_audit_verdict(const hetab_audit *audit);
const hetab_check *hetab_audit_check(const hetab_audit *audit, const char *name);

const char *hetab_verdict_name(hetab_verdict verdict);    /* "PASS" */
const char *hetab_audit_kind_name(hetab_audit_kind kind); /* "surface", "merl", "hdf5",
                                                           * "rgl" */
const char *hetab_reading_name(hetab_reading lookup);     /* "truncate" */

/* What a repair changed. */
typedef struct hetab_repair_report {
  size_t entries;
  size_t replaced;    /* NaN or infinite: the mean of its neighbours along phi, or 0 */
  size_t clamped;     /* negative, now 0 */
  size_t symmetrised; /* averaged with their reciprocal entry, changed by more than 1e-6 of it */
  double max_change_abs, max_change_rel; /* of the last three steps, relative to the larger value */
  size_t scaled_incidences;              /* (channel, theta_i) whose energy exceeded 1 */
  double smallest_scale;                 /* 1: none */
} hetab_repair_report;

/* Writes a repaired copy of the table, HDF5 or MERL: finite, non-negative, reciprocal (MERL: by its
 * format; HDF5: where theta_i and theta_r have the same entries) and, if scale_energy, scaled so
 * that rho_dh <= 1 at every incidence as `lookup` sees it. An entry gets the smaller scale of its
 * two directions, which keeps it reciprocal (without the same entries: that of theta_i). Everything
 * else in the file stays. Refuses to write over its own input: HETAB_ERR_ARGUMENT. */
hetab_status hetab_repair(hetab_context *ctx, const char *path, const char *out_path,
                          hetab_reading lookup, int scale_energy, int overwrite,
                          hetab_repair_report *report);

HETAB_END
