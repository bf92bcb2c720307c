#include <hetab/merl.h>

#include <fcntl.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "core/angle.h"
#include "core/context.h"
#include "core/input_file.h"
#include "core/atomic_file.h"
#include "table/merl_frame.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "MERL files are little-endian, and this file writes memory as it is");

enum { CHANNELS = HETAB_MERL_CHANNELS, BUFFER_CELLS = 16384 };
static const int32_t file_dims[3] = {HETAB_MERL_THETA_H, HETAB_MERL_THETA_D, HETAB_MERL_PHI_D};
static const long long file_bytes = (long long)sizeof file_dims + (long long)CHANNELS *
                                                                      HETAB_MERL_CELLS *
                                                                      (long long)sizeof(double);
static const double file_scale[CHANNELS] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};
static const double below_horizon = -1;
/* The last cell is below the horizon; its blue number is -1 less the cone's degrees, which every
 * reader takes for the same. */
enum { MARKED = CHANNELS - 1 };

struct hetab_merl {
  double values[CHANNELS][HETAB_MERL_CELLS];
  double cone_deg; /* > 0: the specular delta is in the cells, as a lobe that wide */
};

hetab_status hetab_merl_create(hetab_context *ctx, hetab_merl **out) {
  *out = hetab_alloc(ctx, 1, sizeof **out);
  HETAB_NEED(*out);
  for (int c = 0; c < CHANNELS; c++)
    for (size_t i = 0; i < HETAB_MERL_CELLS; i++)
      (*out)->values[c][i] = below_horizon;
  return HETAB_OK;
}

void hetab_merl_free(hetab_merl *merl) {
  free(merl);
}

double *hetab_merl_channel(hetab_merl *merl, int channel) {
  return merl->values[channel];
}

const double *hetab_merl_channel_const(const hetab_merl *merl, int channel) {
  return merl->values[channel];
}

double hetab_merl_specular_cone(const hetab_merl *merl) {
  return hetab_radians(merl->cone_deg);
}

void hetab_merl_set_specular_cone(hetab_merl *merl, double cone) {
  merl->cone_deg = hetab_degrees(cone);
}

/* --- writing -------------------------------------------------------------------------------- */

static int is_below_horizon(const hetab_merl *merl, size_t cell) {
  for (int c = 0; c < CHANNELS; c++)
    if (merl->values[c][cell] != below_horizon)
      return 0;
  return 1;
}

static int is_radiant(const hetab_merl *merl, size_t cell) {
  for (int c = 0; c < CHANNELS; c++)
    if (!(merl->values[c][cell] >= 0 && isfinite(merl->values[c][cell])))
      return 0;
  return 1;
}

/* A negative value that is not the mark of all three channels would be lost on every reader: they
 * take any negative channel for a cell below the horizon. */
static hetab_status check_cells(hetab_context *ctx, const hetab_merl *merl, const char *path) {
  for (size_t i = 0; i < HETAB_MERL_CELLS; i++)
    if (!is_radiant(merl, i) && !is_below_horizon(merl, i))
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "'%s' not written: cell theta_h %zu, theta_d %zu, phi_d %zu holds "
                        "(%g, %g, %g); give three finite values >= 0, or three -1 (below the "
                        "horizon)",
                        path, i / (HETAB_MERL_PHI_D * HETAB_MERL_THETA_D),
                        i / HETAB_MERL_PHI_D % HETAB_MERL_THETA_D, i % HETAB_MERL_PHI_D,
                        merl->values[0][i], merl->values[1][i], merl->values[2][i]);
  return HETAB_OK;
}

static hetab_status write_channel(hetab_context *ctx, hetab_atomic_file *file, const double *values,
                                  double scale, double last) {
  double buffer[BUFFER_CELLS];
  for (size_t first = 0; first < HETAB_MERL_CELLS; first += BUFFER_CELLS) {
    size_t left = HETAB_MERL_CELLS - first;
    size_t count = left < BUFFER_CELLS ? left : BUFFER_CELLS;
    for (size_t i = 0; i < count; i++) {
      double value = values[first + i];
      buffer[i] = value < 0 ? below_horizon : value / scale;
    }
    if (count == left && buffer[count - 1] < 0)
      buffer[count - 1] = last;
    HETAB_TRY(hetab_atomic_write(ctx, file, buffer, count * sizeof *buffer));
  }
  return HETAB_OK;
}

hetab_status hetab_merl_save(hetab_context *ctx, const hetab_merl *merl, const char *path,
                             int overwrite) {
  hetab_atomic_file *file;
  hetab_status status;
  HETAB_TRY(check_cells(ctx, merl, path));
  HETAB_TRY(hetab_atomic_create(ctx, path, overwrite, &file));
  HETAB_GOTO(hetab_atomic_reserve(ctx, file, (unsigned long long)file_bytes));
  HETAB_GOTO(hetab_atomic_write(ctx, file, file_dims, sizeof file_dims));
  for (int c = 0; c < CHANNELS; c++)
    HETAB_GOTO(write_channel(ctx, file, merl->values[c], file_scale[c],
                             below_horizon - (c == MARKED ? merl->cone_deg : 0.0)));
  return hetab_atomic_commit(ctx, file);
done:
  hetab_atomic_abort(file);
  return status;
}

/* --- reading -------------------------------------------------------------------------------- */

static hetab_status read_exactly(hetab_context *ctx, FILE *file, const char *path, void *data,
                                 size_t size) {
  if (fread(data, 1, size, file) == size)
    return HETAB_OK;
  if (ferror(file))
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot read '%s': %m", path);
  return hetab_fail(ctx, HETAB_ERR_PARSE,
                    "'%s' is truncated: a MERL file of 90 x 90 x 180 cells has %lld bytes; get a "
                    "complete copy",
                    path, file_bytes);
}

static int is_byte_swapped(const int32_t dims[3]) {
  for (int i = 0; i < 3; i++)
    if ((int32_t)__builtin_bswap32((uint32_t)dims[i]) != file_dims[i])
      return 0;
  return 1;
}

static hetab_status check_dims(hetab_context *ctx, const char *path, const int32_t dims[3]) {
  if (memcmp(dims, file_dims, sizeof file_dims) == 0)
    return HETAB_OK;
  if (is_byte_swapped(dims))
    return hetab_fail(ctx, HETAB_ERR_PARSE,
                      "'%s' is a big-endian MERL file; swap its bytes: MERL is little-endian",
                      path);
  return hetab_fail(ctx, HETAB_ERR_PARSE,
                    "'%s' is no MERL file: it begins with the dimensions %d x %d x %d in place of "
                    "90 x 90 x 180",
                    path, (int)dims[0], (int)dims[1], (int)dims[2]);
}

static hetab_status check_length(hetab_context *ctx, FILE *file, const char *path) {
  struct stat about;
  if (fstat(fileno(file), &about))
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot read '%s': %m", path);
  if (!S_ISREG(about.st_mode))
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot read '%s': it is not a regular file", path);
  if (about.st_size != file_bytes)
    return hetab_fail(ctx, HETAB_ERR_PARSE,
                      "'%s' has %lld bytes, but a MERL file of 90 x 90 x 180 cells has %lld; get a "
                      "complete copy",
                      path, (long long)about.st_size, file_bytes);
  return HETAB_OK;
}

static bool may_be_marked(size_t cell) {
  hetab_merl_pair pair;
  return !hetab_merl_pair_of(hetab_merl_middle(cell), &pair);
}

/* Stored numbers to 1/sr. A cell with one negative channel is below the horizon to every reader;
 * some writers mark those that are with NaN. */
static hetab_status unscale(hetab_context *ctx, hetab_merl *merl, const char *path) {
  for (size_t i = 0; i < HETAB_MERL_CELLS; i++) {
    bool below = false;
    for (int c = 0; c < CHANNELS; c++) {
      bool finite = isfinite(merl->values[c][i]);
      if (!finite && !(isnan(merl->values[c][i]) && may_be_marked(i)))
        return hetab_fail(ctx, HETAB_ERR_PARSE,
                          "'%s' is damaged: value %zu of channel %d is not a finite number; get a "
                          "complete copy",
                          path, i, c);
      below |= !finite || merl->values[c][i] < 0;
    }
    for (int c = 0; c < CHANNELS; c++)
      merl->values[c][i] = below ? below_horizon : merl->values[c][i] * file_scale[c];
  }
  return HETAB_OK;
}

/* The same, whatever the numbers are. */
static hetab_status unscale_raw(hetab_context *ctx, hetab_merl *merl, const char *path) {
  for (size_t i = 0; i < HETAB_MERL_CELLS; i++) {
    if (is_below_horizon(merl, i))
      continue;
    for (int c = 0; c < CHANNELS; c++)
      merl->values[c][i] *= file_scale[c];
  }
  return HETAB_OK;
}

static void take_mark(hetab_merl *merl) {
  double *mark = &merl->values[MARKED][HETAB_MERL_CELLS - 1], cone_deg = below_horizon - *mark;
  bool is_marked = cone_deg > 0.0 && cone_deg <= 90.0;
  for (int c = 0; c < MARKED; c++)
    is_marked &= merl->values[c][HETAB_MERL_CELLS - 1] == below_horizon;
  merl->cone_deg = is_marked ? cone_deg : 0.0;
  if (is_marked)
    *mark = below_horizon;
}

typedef hetab_status (*unscale_fn)(hetab_context *ctx, hetab_merl *merl, const char *path);

static hetab_status read_file(hetab_context *ctx, FILE *file, const char *path, hetab_merl *merl,
                              unscale_fn finish) {
  int32_t dims[3];
  HETAB_TRY(read_exactly(ctx, file, path, dims, sizeof dims));
  HETAB_TRY(check_dims(ctx, path, dims));
  HETAB_TRY(check_length(ctx, file, path));
  HETAB_TRY(read_exactly(ctx, file, path, merl->values, sizeof merl->values));
  take_mark(merl);
  return finish(ctx, merl, path);
}

static hetab_status load(hetab_context *ctx, const char *path, unscale_fn finish,
                         hetab_merl **out) {
  *out = NULL;
  FILE *file;
  HETAB_TRY(hetab_input_stream(ctx, path, HETAB_INPUT_TABLE, &file));
  hetab_merl *merl = hetab_alloc(ctx, 1, sizeof *merl);
  hetab_status status = merl ? read_file(ctx, file, path, merl, finish) : HETAB_ERR_MEMORY;
  fclose(file);
  *out = merl;
  HETAB_MADE(hetab_merl, out, status);
}

hetab_status hetab_merl_load(hetab_context *ctx, const char *path, hetab_merl **out) {
  return load(ctx, path, unscale, out);
}

hetab_status hetab_merl_load_raw(hetab_context *ctx, const char *path, hetab_merl **out) {
  return load(ctx, path, unscale_raw, out);
}
