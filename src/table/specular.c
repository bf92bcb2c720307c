#include "table/specular.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/angle.h"
#include "core/csv.h"
#include "core/input_file.h"
#include "model/colour.h"

static hetab_status allocate(hetab_context *ctx, size_t channels, size_t count,
                             hetab_specular_table *s) {
  *s = (hetab_specular_table){.channels = channels, .count = count};
  s->cos2_i = hetab_alloc(ctx, count, sizeof *s->cos2_i);
  s->rho = hetab_alloc(ctx, count, channels * sizeof *s->rho);
  return s->cos2_i && s->rho ? HETAB_OK : HETAB_ERR_MEMORY;
}

void hetab_specular_clear(hetab_specular_table *specular) {
  free(specular->cos2_i);
  free(specular->rho);
  *specular = (hetab_specular_table){0};
}

/* As much above 1 as rounding makes of it. */
#define MOST_RHO 1.000001

static float cos2(double theta) {
  return (float)(cos(theta) * cos(theta));
}

static int is_reflectance(double rho) {
  return rho >= 0 && rho <= MOST_RHO;
}

/* ---- HDF5 ---------------------------------------------------------------------------------- */

hetab_status hetab_specular_of_h5(hetab_context *ctx, hetab_h5_table *table, const char *path,
                                  hetab_specular_table *s) {
  const hetab_grid *grid = hetab_h5_grid(table);
  size_t channels = hetab_h5_wavelength_count(table), count = hetab_grid_count(grid, HETAB_THETA_I);
  HETAB_TRY(allocate(ctx, channels, count, s));
  HETAB_FREED double *rho = hetab_alloc(ctx, channels * count, sizeof *rho);
  hetab_status status =
      rho ? hetab_h5_read_specular(ctx, table, rho) : HETAB_ERR_MEMORY; /* [wavelength][theta_i] */
  for (size_t i = 0; i < count && status == HETAB_OK; i++) {
    s->cos2_i[i] = cos2(hetab_grid_radians(grid, HETAB_THETA_I)[i]);
    for (size_t c = 0; c < channels && status == HETAB_OK; c++) {
      s->rho[i * channels + c] = (float)rho[c * count + i];
      if (!is_reflectance(rho[c * count + i]))
        status = hetab_fail(ctx, HETAB_ERR_PARSE,
                            "'%s' is damaged: /specular_reflectance holds %g at wavelength %zu, "
                            "theta_i %zu; get a complete copy",
                            path, rho[c * count + i], c, i);
    }
  }
  return status;
}

double hetab_specular_cone_of_h5(hetab_context *ctx, hetab_h5_table *table) {
  double deg = 0.0;
  bool folded = hetab_h5_number(ctx, table, HETAB_H5_CONE, &deg) == HETAB_OK;
  return folded && deg > 0.0 && deg <= 90.0 ? hetab_radians(deg) : 0.0;
}

/* ---- CSV ----------------------------------------------------------------------------------- */

typedef struct csv_row {
  double um, theta, rho;
} csv_row;

typedef struct csv {
  csv_row *rows; /* wavelength by wavelength, each over the same angles */
  size_t count, room, angles, waves;
} csv;

enum { MOST_BYTES = 256 << 20, COLUMNS = 3 };

static hetab_status read_rows(hetab_csv *text, csv *file) {
  static const hetab_csv_wanted wanted[COLUMNS] = {
      {"wavelength|lambda", HETAB_LENGTH}, {"thetai", HETAB_ANGLE}, {"rhos", HETAB_PLAIN}};
  static const hetab_rule rules[COLUMNS] = {{1e-9, 1e6, "a wavelength above 0"},
                                            {0, M_PI_2, "theta_i in [0, 90] degrees"},
                                            {0, MOST_RHO, "rho_s in [0, 1]"}};
  static const char header[] = "wavelength_nm,theta_i_deg,rho_s";
  size_t at[COLUMNS];
  HETAB_TRY(hetab_csv_header(text, wanted, COLUMNS));
  for (int c = 0; c < COLUMNS; c++) {
    HETAB_TRY(hetab_csv_find(text, c, header, &at[c]));
    if (at[c] == HETAB_CSV_ABSENT)
      return hetab_csv_fail(text, "expected the header %s", header);
  }
  for (;; file->count++) {
    HETAB_TRY(hetab_csv_row(text));
    if (!text->count)
      return file->count ? HETAB_OK : hetab_csv_fail(text, "holds no rows");
    HETAB_TRY(hetab_grow(text->ctx, &file->rows, sizeof *file->rows, file->count + 1, &file->room));
    csv_row *row = &file->rows[file->count];
    double *const values[COLUMNS] = {&row->um, &row->theta, &row->rho};
    for (int c = 0; c < COLUMNS; c++)
      HETAB_TRY(hetab_csv_number(text, at[c], &rules[c], values[c]));
  }
}

/* A delta held from there on would not be a surface's: what ends before has been cut. */
static const double LEAST_LAST_DEG = 80;

static hetab_status check_order(hetab_context *ctx, const char *path, csv *file) {
  const csv_row *rows = file->rows;
  while (file->angles < file->count && rows[file->angles].um == rows[0].um)
    file->angles++;
  file->waves = file->count / file->angles;
  int sound = file->waves * file->angles == file->count;
  for (size_t i = 0; i < file->count && sound; i++) {
    size_t wave = i / file->angles, angle = i % file->angles;
    sound = rows[i].theta == rows[angle].theta && rows[i].um == rows[wave * file->angles].um &&
            (angle == 0 || rows[i].theta > rows[i - 1].theta) &&
            (wave == 0 || file->waves == 3 || rows[i].um > rows[i - file->angles].um);
  }
  if (!sound)
    return hetab_fail(ctx, HETAB_ERR_PARSE,
                      "'%s': wavelengths ascend, each with the same ascending angles", path);
  double last = hetab_degrees(rows[file->angles - 1].theta);
  return last >= LEAST_LAST_DEG
             ? HETAB_OK
             : hetab_fail(ctx, HETAB_ERR_PARSE,
                          "'%s' ends at theta_i %g degrees: get a complete copy, to %g or more",
                          path, last, LEAST_LAST_DEG);
}

/* Linear between the file's wavelengths, held beyond them. */
static void band_weights(const double *from_um, size_t waves, const double *to_um, size_t channels,
                         double *weight) {
  for (size_t c = 0; c < channels; c++) {
    size_t right = 1;
    while (right + 1 < waves && from_um[right] < to_um[c])
      right++;
    if (waves == 1) {
      weight[c] = 1;
      continue;
    }
    double t = (to_um[c] - from_um[right - 1]) / (from_um[right] - from_um[right - 1]);
    t = fmin(fmax(t, 0), 1);
    weight[(right - 1) * channels + c] = 1 - t;
    weight[right * channels + c] = t;
  }
}

static hetab_status mix(hetab_context *ctx, const csv *file, size_t channels,
                        const double *lambda_um, hetab_specular_table *s) {
  HETAB_FREED double *from_um = hetab_alloc(ctx, file->waves, sizeof *from_um);
  HETAB_FREED double *weight = hetab_alloc(ctx, file->waves, channels * sizeof *weight);
  hetab_status status =
      from_um && weight ? allocate(ctx, channels, file->angles, s) : HETAB_ERR_MEMORY;
  for (size_t w = 0; w < file->waves && status == HETAB_OK; w++)
    from_um[w] = file->rows[w * file->angles].um;
  if (status == HETAB_OK && lambda_um)
    band_weights(from_um, file->waves, lambda_um, channels, weight);
  else if (status == HETAB_OK && (file->waves == 1 || file->waves == channels))
    for (size_t c = 0; c < channels; c++) /* the channels themselves: no spectrum is that short */
      weight[(file->waves == 1 ? 0 : c) * channels + c] = 1;
  else if (status == HETAB_OK)
    status = hetab_srgb_weights(ctx, from_um, file->waves, (double(*)[3])weight);
  for (size_t i = 0; i < file->angles && status == HETAB_OK; i++) {
    s->cos2_i[i] = cos2(file->rows[i].theta);
    for (size_t c = 0; c < channels; c++) {
      double sum = 0;
      for (size_t w = 0; w < file->waves; w++)
        sum += weight[w * channels + c] * file->rows[w * file->angles + i].rho;
      s->rho[i * channels + c] = (float)fmax(sum, 0);
    }
  }
  return status;
}

static hetab_status read_csv(hetab_context *ctx, const char *path, size_t channels,
                             const double *lambda_um, hetab_specular_table *s) {
  csv file = {0};
  hetab_csv text;
  int fd;
  hetab_status status = hetab_input_open(ctx, path, HETAB_INPUT_TABLE, &fd);
  if (fd < 0)
    return errno == ENOENT || errno == ENOTDIR ? HETAB_OK : status;
  close(fd);
  HETAB_TRY(hetab_csv_open(ctx, path, MOST_BYTES, &text));
  status = read_rows(&text, &file);
  if (status == HETAB_OK)
    status = check_order(ctx, path, &file);
  if (status == HETAB_OK)
    status = mix(ctx, &file, channels, lambda_um, s);
  hetab_csv_clear(&text);
  free(file.rows);
  return status;
}

hetab_status hetab_specular_beside(hetab_context *ctx, const char *path, size_t channels,
                                   const double *lambda_um, hetab_specular_table *s) {
  *s = (hetab_specular_table){.channels = channels};
  HETAB_FREED char *beside = hetab_specular_path(ctx, path);
  HETAB_NEED(beside);
  return read_csv(ctx, beside, channels, lambda_um, s);
}

/* ---- writing ------------------------------------------------------------------------------- */

char *hetab_specular_path(hetab_context *ctx, const char *path) {
  char *name;
  const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
  int stem = (int)(dot && (!slash || dot > slash) ? (size_t)(dot - path) : strlen(path));
  if (asprintf(&name, "%.*s.specular.csv", stem, path) >= 0)
    return name;
  hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for the name of '%s'", path);
  return NULL;
}

static void write_rows(FILE *stream, const double *lambda_um, size_t count, bool are_channels,
                       const double *rho) {
  static const char *const names[] = {"r", "g", "b"};
  const double least = 1e-30; /* readers in C++ refuse subnormal numbers */
  fprintf(stream, "wavelength_nm,theta_i_deg,rho_s%s\n", are_channels ? ",channel" : "");
  for (size_t w = 0; w < count; w++)
    for (int i = 0; i < HETAB_SPECULAR_ANGLES; i++) {
      double value = rho[w * HETAB_SPECULAR_ANGLES + (size_t)i];
      fprintf(stream, "%.10g,%d,%.9g", 1000 * lambda_um[w], i, value < least ? 0.0 : value);
      fprintf(stream, are_channels ? ",%s\n" : "%.0s\n", count == 1 ? "mono" : names[w % 3]);
    }
}

/* Whether the file under a path is this text already. */
static bool is_there(const char *path, const char *text, size_t size) {
  FILE *stream = fopen(path, "rb");
  bool same = stream != NULL;
  for (size_t i = 0; same && i < size; i++)
    same = getc(stream) == (unsigned char)text[i];
  same = same && getc(stream) == EOF;
  if (stream)
    fclose(stream);
  return same;
}

hetab_status hetab_specular_save(hetab_context *ctx, const char *path, const double *lambda_um,
                                 size_t count, bool are_channels, const double *rho,
                                 int overwrite) {
  HETAB_FREED char *text = NULL;
  size_t size;
  FILE *stream = open_memstream(&text, &size);
  if (!stream)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for '%s'", path);
  write_rows(stream, lambda_um, count, are_channels, rho);
  hetab_status status = HETAB_OK;
  if (fclose(stream))
    status = hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for '%s'", path);
  else if (overwrite || !is_there(path, text, size))
    status = hetab_text_save(ctx, path, text, size, overwrite);
  return status;
}

/* ---- looking up ---------------------------------------------------------------------------- */

/* Between two incidences along the logarithm, but from 0, and from where b / a could overflow. */
static float between(float a, float b, float t) {
  return a >= FLT_MIN && b >= FLT_MIN ? a * powf(b / a, t) : a + t * (b - a);
}

void hetab_specular_at(const hetab_specular_table *s, float cos_i, const hetab_band_places *places,
                       float *value) {
  size_t count = places ? places->count : s->channels, low = 0, high = s->count - 1;
  memset(value, 0, count * sizeof *value);
  if (!s->count || !(cos_i > 0))
    return;
  float cos2_i = fminf(cos_i * cos_i, 1), t = 0;
  while (high - low > 1) {
    size_t middle = (low + high) / 2;
    if (s->cos2_i[middle] >= cos2_i)
      low = middle;
    else
      high = middle;
  }
  if (high > low)
    t = (cos2_i - s->cos2_i[low]) / (s->cos2_i[high] - s->cos2_i[low]);
  t = fminf(fmaxf(t, 0), 1);
  const float *a = s->rho + low * s->channels, *b = s->rho + high * s->channels;
  for (size_t c = 0; c < count; c++) {
    size_t first = places ? places->first[c] : c;
    value[c] = between(a[first], b[first], t);
    if (places && places->fraction[c] > 0)
      value[c] += places->fraction[c] * (between(a[first + 1], b[first + 1], t) - value[c]);
  }
}
