/* Roughness from measured heights: the scans of a profilometer or a height map in, the model's
 * sigma0 and tau out, with their errors (section 2 of Li & Torrance, TR PCG-05-02, Eqs. 1-2).
 *
 * Heights and lengths are in um. A scan is a row of equally spaced heights; NaN marks a height
 * that is missing. A map gives one scan per row and per column. */
#pragma once

#include <stddef.h>
#include <hetab/status.h>

HETAB_BEGIN

/* ---- heights ------------------------------------------------------------------------------- */

/* Threads: once made, they do not change and may be shared. */
typedef struct hetab_heights hetab_heights;

typedef enum hetab_heights_kind {
  HETAB_HEIGHTS_SCANS, /* rows are scans that have nothing to do with each other */
  HETAB_HEIGHTS_MAP    /* rows lie spacing_y_um apart on one surface */
} hetab_heights_kind;

/* What a text file does not say of itself; 0 and NULL: the file has to say it. */
typedef struct hetab_heights_options {
  size_t size;          /* of the struct; 0: of this header's */
  double spacing_um;    /* between neighbours, of heights without x; of maps in both directions */
  const char *unit;     /* "nm", "um", "mm" or "m": of numbers whose header names no unit; "mm,um":
                         * of places and of heights */
  double resample_um;   /* interpolate scans with x linearly on places this far apart; 0: do not */
  const char *columns;  /* "z", "x,z" or "x,y,z": names in the header, or numbers from 1 */
  char decimal;         /* '.' or ',' where the file allows both readings */
  int ignore_checksums; /* of X3P */
} hetab_heights_options;

/* Told apart by content; what comes through a pipe is text or ASCII SDF:
 * - text in UTF-8, UTF-16 or Latin-1, columns separated by semicolons, tabs, commas or blanks,
 *   fields perhaps in double quotes, decimal commas where the file allows no other reading, '#'
 *   starts a comment; lines of anything above the rows are passed over. A header "x_um,z_nm" (also
 *   "Lateral um,Raw Micrometer", "x in um", "Height (nm)", or units in a line of their own) names
 *   the columns; every z column is a scan; x, y and z are a list of points on a grid; without an x
 *   column options.spacing_um is needed. Without a header options.unit is needed: one column is z,
 *   two are x and z, three are points if the first two lie on a grid, more are a map, row by row;
 * - text maps with their size and unit above the rows, as Gwyddion (in English, German, French),
 *   SPIP, Attocube, Nova, Lyncee and Wyko write them; Zygo's ASCII;
 * - X3P (ISO 5436-2): profiles and surfaces, 16- and 32-bit integers, float, double, data in a
 *   binary file or in the XML, validity mask; checksums are verified;
 * - SDF (ISO 25178-71), ASCII and binary, and Digital Surf's .sur, not compressed.
 * Missing heights: empty fields, "nan", "bad", "-", the formats' own marks, steps of x that are
 * multiples of the usual one. Unequal steps of x (more than 2 % off, unless rounding on paper
 * explains them) are refused, unless options.resample_um is given; steps of more than three times
 * the median then are gaps.
 * Failures name the file and, in text, the line. At most 2^27 heights, files up to 1 GiB. */
hetab_status hetab_heights_load(hetab_context *ctx, const char *path,
                                const hetab_heights_options *options, hetab_heights **out);
/* From memory: z_um[rows][columns]; spacing_y_um of maps only. */
hetab_status hetab_heights_create(hetab_context *ctx, const char *name, hetab_heights_kind kind,
                                  const double *z_um, size_t columns, size_t rows,
                                  double spacing_um, double spacing_y_um, hetab_heights **out);
void hetab_heights_free(hetab_heights *heights); /* NULL is fine */

const char *hetab_heights_name(const hetab_heights *heights);
hetab_heights_kind hetab_heights_kind_of(const hetab_heights *heights);
size_t hetab_heights_column_count(const hetab_heights *heights); /* points of a row */
size_t hetab_heights_row_count(const hetab_heights *heights);
double hetab_heights_spacing_um(const hetab_heights *heights);
double hetab_heights_spacing_y_um(const hetab_heights *heights); /* 0: not a map */
const double *hetab_heights_z_um(const hetab_heights *heights);  /* [rows][columns] */

/* ---- what to do with them ------------------------------------------------------------------ */

typedef enum hetab_level {
  HETAB_LEVEL_FIT, /* subtract the least-squares line of a scan, the plane of a map */
  HETAB_LEVEL_NONE
} hetab_level;

/* What separates the small scale from the mean line, by the wavelength `cutoff`. */
typedef enum hetab_filter {
  HETAB_FILTER_GAUSSIAN, /* ISO 16610-21: the line keeps 2^-(cutoff/wavelength)^2 */
  HETAB_FILTER_ROBUST,   /* ISO 16610-31, order 0: likewise, heights far off the line count less */
  HETAB_FILTER_FOURIER,  /* the line keeps what is longer than the cut-off */
  HETAB_FILTER_AVERAGE   /* the mean of the heights within half a cut-off on either side */
} hetab_filter;
const char *hetab_filter_name(hetab_filter filter); /* "Gaussian" */

/* Zeroed: level by fit, no separation of scales, outliers by the default. */
typedef struct hetab_roughness_options {
  size_t size; /* of the struct; 0: of this header's */
  /* Of the filter, um; 0: no filter; HETAB_CUTOFF_AUTO, Gaussian only: the cut-off with the largest
   * small-scale slope, none where the scans have one scale. */
  double cutoff_um;
  hetab_filter filter;
  hetab_level level;
  /* Heights that differ from the median of the 7 about them by more than this many times the
   * robust standard deviation of all are outliers, and left out; 0: 6; negative: none are. */
  double outlier;
  double wavelength_um; /* that the radius of curvature is judged against; 0: 0.7 */
} hetab_roughness_options;

#define HETAB_CUTOFF_AUTO (-1.0)

/* ---- results ------------------------------------------------------------------------------- */

/* A number and its standard error, from the one scan: Bartlett's formula with the scan's own
 * autocorrelation, so that the finite length is in it. */
typedef struct hetab_estimate {
  double value, error;
} hetab_estimate;

/* One scan. sigma: Eq. 2, the root of the mean square about the mean, divisor n. Autocorrelation:
 * Eq. 1, products z(x) z(x + r) summed over all pairs, divisor n, over sigma^2. tau: where it first
 * falls to 1/e, linear between lags. slope: sigma / tau, the report's. rms_slope: of first
 * differences, another quantity: sqrt(2) sigma / tau for a Gaussian autocorrelation, without limit
 * for an exponential one as the spacing shrinks.
 *
 * Bias. Of unfiltered scans: the mean and the line that are taken away carry variance of the
 * surface: sigma comes out low by about 2 tau / length, tau by 2.5 (scans of 50 tau). After the
 * filter it is below 1 % for scans of 60 tau (tests/test_roughness.c). The filter takes variance
 * from the small scale too: of a Gaussian autocorrelation with tau = 5.6 um a 30 um cut-off leaves
 * less than a third of the variance and tau = 3.2 um, but 96 % of sigma / tau; at about 13 tau
 * sigma / tau is largest, 8 % above the surface's own. */
typedef struct hetab_scan_statistics {
  size_t scan; /* in hetab_roughness.scans */
  size_t points;
  double length_um; /* points times spacing */
  hetab_estimate sigma_um, tau_um, slope, rms_slope;
  hetab_estimate skewness, kurtosis; /* 0 and 3 for Gaussian heights; errors as if they were */
  double independent;     /* as many independent heights would give sigma with the same error */
  double normal_distance; /* largest |F - F_Gauss| of the heights' distribution functions */
  /* rms difference of the autocorrelation, for lags up to 1.5 tau, from exp(-(r/tau)^2) and from
   * exp(-r/tau) */
  double misfit_gaussian, misfit_exponential;
} hetab_scan_statistics;

/* Over scans. deviation: divisor n - 1, NaN of one scan. error: the larger of what the scatter of
 * the scans and what their own errors say; low, high: 95 % interval of the mean, from the larger
 * likewise (Student's t for the scatter); of sigma, tau and the slopes in the logarithm, above 0.
 * Neighbouring rows of a map are no independent scans: they count as map width / (1.25 tau). */
typedef struct hetab_average {
  size_t count; /* of scans with a finite value */
  double mean, deviation, error, low, high;
} hetab_average;

enum { HETAB_HISTOGRAM_BINS = 60, HETAB_CORRELATION_LAGS = 201 };

typedef struct hetab_component {
  hetab_scan_statistics *scans; /* [count] those with enough points left */
  size_t count;
  hetab_average sigma_um, tau_um, slope, rms_slope, skewness, kurtosis;
  double non_uniformity; /* deviation of sigma over its mean; NaN of one scan */
  double normal_distance, misfit_gaussian, misfit_exponential; /* means */
  /* Density of z / sigma from -5 to 5, and the mean autocorrelation at lag_um[i] = i lag_step_um */
  double histogram[HETAB_HISTOGRAM_BINS];
  double correlation[HETAB_CORRELATION_LAGS], lag_step_um;
} hetab_component;

typedef struct hetab_scan_source {
  const char *name; /* "a.csv", "b.x3p row 3" */
  double spacing_um;
  size_t points, missing, outliers; /* outliers and missing are not among the points used */
} hetab_scan_source;

/* One cut-off of HETAB_CUTOFF_AUTO. `smooth` is the slope of two Gaussian components, fitted to
 * sigma and tau at all cut-offs: the maximum is so flat that noise alone would decide where it is.
 */
typedef struct hetab_cutoff_trial {
  double cutoff_um, sigma_um, tau_um, slope, smooth;
} hetab_cutoff_trial;

typedef struct hetab_cutoff_scan {
  hetab_cutoff_trial *trials; /* [count], cut-offs ascending */
  size_t count;
  double sigma_um[2], tau_um[2]; /* the two components, before any filter; the small one first */
  double misfit;                 /* weighted rms relative difference of sigma and tau */
  int from_fit; /* the cut-off is the fit's; 0: the fit is poor, it is the largest slope's */
} hetab_cutoff_scan;

typedef struct hetab_roughness {
  hetab_scan_source *scans; /* [count] */
  size_t count;
  hetab_component raw;   /* levelled, not filtered */
  hetab_component small; /* after the filter; count 0 without */
  double cutoff_um;      /* 0: none */
  hetab_filter filter;
  hetab_cutoff_scan cutoff_scan;
  /* The first scan in two: levelled heights and the mean line, [split_count], NaN where missing;
   * the first and the last half cut-off of the line are end zones. */
  double *split_levelled_um, *split_line_um;
  size_t split_count;
  double curvature_um; /* rms radius of curvature tau^2 / (sqrt(12) sigma) */
  char **notes;        /* [note_count] sentences about assumptions that do not hold */
  size_t note_count;
} hetab_roughness;

/* All scans of all inputs. Weights of the filter that reach beyond the end or into a gap are
 * dropped and the rest renormalised; the first and the last half cut-off are not evaluated (the
 * standard's end zones, truncation constant 0.5: elsewhere less than 0.4 % of the weights are
 * missing). A gap longer than a tenth of the cut-off ends a scan like its ends do. Cut-off: at
 * least 10 spacings, at most half a scan. HETAB_ERR_RANGE if no scan has 32 points left or all
 * heights are equal.
 *
 * Error (tests/test_roughness.c): 9 scans of 4000 points at 0.1 um, Gaussian autocorrelations of
 * the report's five surfaces plus a large scale (1 um, 150 um), against the process's own filtered
 * statistics. Cut-off 30 um: of sigma, tau, sigma / tau and the rms slope the bias is at most 1 %,
 * the spread 3.5 %, and the 95 % intervals cover in 95 % of 200 trials or more. Cut-off auto: none
 * in at most 1 % of the trials, where levelling left nothing of the large scale; else within 13 %
 * of the process's cut-off of largest slope. */
hetab_status hetab_roughness_measure(hetab_context *ctx, const hetab_heights *const *heights,
                                     size_t count, const hetab_roughness_options *options,
                                     hetab_roughness **out);
void hetab_roughness_free(hetab_roughness *roughness); /* NULL is fine */

/* The mean line of one scan z_um[count] (NaN: missing), as above; line_um[count]; evaluated[i] is 1
 * where the scan is neither missing nor in an end zone. */
hetab_status hetab_mean_line(hetab_context *ctx, hetab_filter filter, const double *z_um,
                             size_t count, double spacing_um, double cutoff_um, double *line_um,
                             unsigned char *evaluated);

/* ---- published rows ------------------------------------------------------------------------ */

enum { HETAB_AVERAGE, HETAB_DEVIATION, HETAB_NON_UNIFORMITY, HETAB_SUMMARIES };
const char *hetab_summary_name(int kind); /* "average" */

typedef struct hetab_published_column {
  char *name;
  int decimals;                   /* of the rows */
  double *values;                 /* [rows] */
  double stated[HETAB_SUMMARIES]; /* what the table itself says of them; NaN: nothing */
  int stated_decimals[HETAB_SUMMARIES];
} hetab_published_column;

typedef struct hetab_published_table {
  char *name; /* the file */
  size_t rows, count;
  char **row_names;                /* [rows] */
  hetab_published_column *columns; /* [count] */
} hetab_published_table;

typedef enum hetab_match {
  HETAB_MATCH_EXACT,    /* to the digit that is printed */
  HETAB_MATCH_ROUNDING, /* of rows that round to the printed ones */
  HETAB_MATCH_OWN_ROW,  /* not from the other table, but from its own row's sigma and tau */
  HETAB_MATCH_NONE      /* an error of the print */
} hetab_match;
const char *hetab_match_name(hetab_match verdict); /* "agrees" */

/* A printed number and what it has to be. */
typedef struct hetab_published_check {
  size_t table, against;    /* where it stands, and whose rows it is checked against */
  const char *row, *column; /* "average", or a row's name */
  double stated;
  int decimals;
  double value, low, high; /* from the rows as printed, and from rows that round to them */
  hetab_match verdict;
} hetab_published_check;

typedef struct hetab_published {
  hetab_published_table *tables; /* [count] */
  size_t count;
  hetab_published_check *checks; /* [check_count] */
  size_t check_count;
} hetab_published;

/* CSV: a header, whose first column names the scans; rows named average, deviation and
 * non-uniformity hold what the table states. Checked are these; slope = sigma / tau in every row of
 * a table with such columns; and, of several tables, the row of one that shares at least two of
 * another's averages. */
hetab_status hetab_published_load(hetab_context *ctx, const char *const *paths, size_t count,
                                  hetab_published **out);
/* HETAB_AVERAGE ... of a column's rows as printed; deviation: divisor n - 1. */
double hetab_published_summary(const hetab_published_table *table, size_t column, int kind);
void hetab_published_free(hetab_published *published); /* NULL is fine */

HETAB_END
