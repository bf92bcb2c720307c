#include "table/exr_file.h"

#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <openexr.h>

#include "core/context.h"
#include "core/atomic_file.h"

enum { MAX_PATCHES = 8 };

typedef struct patch {
  const char *name;
  double value;
} patch;

struct hetab_exr_file {
  hetab_atomic_file *atomic;
  exr_context_t exr;
  exr_result_t result; /* of the first call that failed */
  int error;           /* errno of the first write that failed */
  int part;            /* added last */
  size_t header_size;
  patch patches[MAX_PATCHES];
  int patch_count;
};

/* ---- the library's stream ------------------------------------------------------------------ */

/* The library reports with its lock held: whatever is called here may wait for that lock forever,
 * and the default prints. The result codes say enough. */
static void ignore_error(exr_const_context_t exr, exr_result_t code, const char *message) {}

/* Returns 0, or the errno value. */
static int write_at(int fd, const char *data, uint64_t size, uint64_t offset) {
  while (size) {
    ssize_t written = pwrite(fd, data, size, (off_t)offset);
    if (written < 0 && errno != EINTR)
      return errno;
    if (written > 0) {
      data += written;
      size -= (uint64_t)written;
      offset += (uint64_t)written;
    }
  }
  return 0;
}

static int64_t write_stream(exr_const_context_t exr, void *user, const void *data, uint64_t size,
                            uint64_t offset, exr_stream_error_func_ptr_t report) {
  hetab_exr_file *file = user;
  (void)report;
  if (!file->error)
    file->error = write_at(hetab_atomic_fd(file->atomic), data, size, offset);
  return file->error ? -1 : (int64_t)size;
}

/* ---- failures ------------------------------------------------------------------------------ */

static void note(hetab_exr_file *file, exr_result_t result) {
  if (file->result == EXR_ERR_SUCCESS)
    file->result = result;
}

static int failed(const hetab_exr_file *file) {
  return file->result != EXR_ERR_SUCCESS || file->error;
}

/* A write that failed comes before whatever the library makes of it. Writing, it calls a chunk
 * corrupt where zlib had no memory. */
static hetab_status outcome(hetab_context *ctx, const hetab_exr_file *file) {
  if (file->error)
    return hetab_atomic_fail(ctx, file->atomic, file->error);
  if (file->result == EXR_ERR_OUT_OF_MEMORY || file->result == EXR_ERR_CORRUPT_CHUNK)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory while writing '%s'",
                      hetab_atomic_path(file->atomic));
  if (file->result != EXR_ERR_SUCCESS)
    return hetab_fail(ctx, HETAB_ERR_IO, "cannot write '%s': OpenEXR: %s",
                      hetab_atomic_path(file->atomic), exr_get_error_code_as_string(file->result));
  return HETAB_OK;
}

/* ---- names --------------------------------------------------------------------------------- */

void hetab_exr_part_name(const char *prefix, const char *unit, const double *values, size_t count,
                         size_t i, char name[HETAB_EXR_NAME]) {
  double gap = (double)INFINITY;
  for (size_t k = 1; k < count; k++)
    gap = fmin(gap, values[k] - values[k - 1]);
  int decimals = gap < 0.01 ? (int)fmin(ceil(-log10(gap)) + 1, 15) : 2;
  int width = snprintf(NULL, 0, "%.*f", decimals, values[count - 1]);
  snprintf(name, HETAB_EXR_NAME, "%s%0*.*f%s", prefix, width, decimals, values[i], unit);
  for (char *dot = name; (dot = strchr(dot, '.'));) /* which part layers and views for readers */
    *dot = '_';
}

/* ---- the header ---------------------------------------------------------------------------- */

hetab_status hetab_exr_file_create(hetab_context *ctx, hetab_atomic_file *atomic,
                                   hetab_exr_file **out) {
  hetab_status status;
  exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
  *out = NULL;
  hetab_exr_file *file = hetab_alloc(ctx, 1, sizeof *file);
  if (!file)
    return HETAB_ERR_MEMORY;
  file->atomic = atomic;
  file->part = -1;
  start.error_handler_fn = ignore_error;
  start.user_data = file;
  start.write_fn = write_stream;
  note(file,
       exr_start_write(&file->exr, hetab_atomic_path(atomic), EXR_WRITE_FILE_DIRECTLY, &start));
  if (!failed(file)) /* which old readers do not know, and no name needs */
    note(file, exr_set_longname_support(file->exr, 0));
  HETAB_GOTO(outcome(ctx, file));
  *out = file;
  return HETAB_OK;
done:
  hetab_exr_file_free(file);
  return status;
}

void hetab_exr_file_part(hetab_exr_file *file, const hetab_exr_part *part, int display_width,
                         int display_height) {
  const exr_attr_box2i_t display = {{.x = 0}, {.x = display_width - 1, .y = display_height - 1}};
  const exr_attr_box2i_t data = {{.x = 0}, {.x = part->width - 1, .y = part->height - 1}};
  const exr_attr_v2f_t centre = {.x = 0};
  if (failed(file))
    return;
  note(file, exr_add_part(file->exr, part->name, EXR_STORAGE_SCANLINE, &file->part));
  if (!failed(file))
    note(file, exr_initialize_required_attr(file->exr, file->part, &display, &data, 1, &centre, 1,
                                            EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP));
  for (int c = 0; c < part->channel_count && !failed(file); c++)
    note(file, exr_add_channel(file->exr, file->part, part->channels[c],
                               part->half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
}

void hetab_exr_put_text(hetab_exr_file *file, const char *name, const char *value) {
  if (!failed(file))
    note(file, exr_attr_set_string(file->exr, file->part, name, value));
}

void hetab_exr_put_double(hetab_exr_file *file, const char *name, double value) {
  if (!failed(file))
    note(file, exr_attr_set_double(file->exr, file->part, name, value));
}

void hetab_exr_put_vector(hetab_exr_file *file, const char *name, const float *values,
                          size_t count) {
  if (!failed(file))
    note(file, exr_attr_set_float_vector(file->exr, file->part, name, (int32_t)count, values));
}

void hetab_exr_put_chromaticities(hetab_exr_file *file) {
  const exr_attr_chromaticities_t rec709 = {.red_x = 0.64f,
                                            .red_y = 0.33f,
                                            .green_x = 0.3f,
                                            .green_y = 0.6f,
                                            .blue_x = 0.15f,
                                            .blue_y = 0.06f,
                                            .white_x = 0.3127f,
                                            .white_y = 0.329f};
  if (!failed(file))
    note(file, exr_attr_set_chromaticities(file->exr, file->part, "chromaticities", &rec709));
}

/* The size of what has been written is that of the header with its tables of offsets. */
hetab_status hetab_exr_file_begin(hetab_context *ctx, hetab_exr_file *file) {
  if (!failed(file))
    note(file, exr_write_header(file->exr));
  HETAB_TRY(outcome(ctx, file));
  off_t end = lseek(hetab_atomic_fd(file->atomic), 0, SEEK_END);
  file->header_size = end > 0 ? (size_t)end : 0;
  return HETAB_OK;
}

/* ---- pixels -------------------------------------------------------------------------------- */

static int channel_index(const hetab_exr_part *part, const char *name) {
  int c = 0;
  while (c + 1 < part->channel_count && strcmp(part->channels[c], name) != 0)
    c++;
  return c;
}

/* Where the channels of the chunk that starts at row y come from. The library sorts channels by
 * name: order[channel of the file] is the caller's. */
static void point_channels(exr_encode_pipeline_t *pipeline, const hetab_exr_part *part,
                           const int *order, const float *const *planes, int y) {
  for (int c = 0; c < pipeline->channel_count; c++) {
    exr_coding_channel_info_t *channel = &pipeline->channels[c];
    const float *from = planes[order[c]] + (size_t)y * (size_t)part->width;
    channel->user_data_type = EXR_PIXEL_FLOAT;
    channel->user_bytes_per_element = (int16_t)sizeof *from;
    channel->user_pixel_stride = (int32_t)sizeof *from;
    channel->user_line_stride = part->width * (int32_t)sizeof *from;
    channel->encode_from_ptr = (const uint8_t *)from;
  }
}

static exr_result_t start_chunks(hetab_exr_file *file, int number, const exr_chunk_info_t *chunk,
                                 const hetab_exr_part *part, const float *const *planes, int *order,
                                 exr_encode_pipeline_t *pipeline) {
  exr_result_t result = exr_encoding_initialize(file->exr, number, chunk, pipeline);
  if (result != EXR_ERR_SUCCESS)
    return result;
  for (int c = 0; c < pipeline->channel_count; c++)
    order[c] = channel_index(part, pipeline->channels[c].channel_name);
  point_channels(pipeline, part, order, planes, 0);
  return exr_encoding_choose_default_routines(file->exr, number, pipeline);
}

static exr_result_t write_chunks(hetab_exr_file *file, int number, const hetab_exr_part *part,
                                 const float *const *planes, int *order,
                                 exr_encode_pipeline_t *pipeline) {
  int32_t lines;
  exr_result_t result = exr_get_scanlines_per_chunk(file->exr, number, &lines);
  for (int y = 0; y < part->height && result == EXR_ERR_SUCCESS; y += lines) {
    exr_chunk_info_t chunk;
    result = exr_write_scanline_chunk_info(file->exr, number, y, &chunk);
    if (result == EXR_ERR_SUCCESS)
      result = y ? exr_encoding_update(file->exr, number, &chunk, pipeline)
                 : start_chunks(file, number, &chunk, part, planes, order, pipeline);
    if (result != EXR_ERR_SUCCESS)
      break;
    point_channels(pipeline, part, order, planes, y);
    result = exr_encoding_run(file->exr, number, pipeline);
  }
  return result;
}

hetab_status hetab_exr_file_write(hetab_context *ctx, hetab_exr_file *file, int number,
                                  const hetab_exr_part *part, const float *const *planes) {
  exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
  int *order = hetab_alloc(ctx, (size_t)part->channel_count, sizeof *order);
  if (!order)
    return HETAB_ERR_MEMORY;
  if (!failed(file)) {
    note(file, write_chunks(file, number, part, planes, order, &pipeline));
    exr_encoding_destroy(file->exr, &pipeline);
  }
  free(order);
  return outcome(ctx, file);
}

/* ---- the end ------------------------------------------------------------------------------- */

void hetab_exr_file_patch(hetab_exr_file *file, const char *name, double value) {
  if (file->patch_count < MAX_PATCHES)
    file->patches[file->patch_count++] = (patch){name, value};
}

/* An attribute is name, NUL, type, NUL, size, value; the numbers little-endian. */
static void patch_header(char *header, size_t size, const patch *p) {
  static const char type[] = "double\0\10\0\0"; /* and a NUL more */
  char key[64];
  size_t name = strlen(p->name) + 1, length = name + sizeof type;
  memcpy(key, p->name, name);
  memcpy(key + name, type, sizeof type);
  for (char *at = header; (at = memmem(at, size - (size_t)(at - header), key, length));) {
    at += length;
    memcpy(at, &p->value, sizeof p->value);
  }
}

static hetab_status apply_patches(hetab_context *ctx, hetab_exr_file *file) {
  int fd = hetab_atomic_fd(file->atomic);
  if (!file->patch_count)
    return HETAB_OK;
  char *header = hetab_alloc(ctx, file->header_size, 1);
  if (!header)
    return HETAB_ERR_MEMORY;
  if (pread(fd, header, file->header_size, 0) != (ssize_t)file->header_size)
    file->error = errno ? errno : EIO;
  for (int i = 0; i < file->patch_count; i++)
    patch_header(header, file->header_size, &file->patches[i]);
  if (!file->error)
    file->error = write_at(fd, header, file->header_size, 0);
  free(header);
  return outcome(ctx, file);
}

hetab_status hetab_exr_file_finish(hetab_context *ctx, hetab_exr_file *file) {
  if (file->exr)
    note(file, exr_finish(&file->exr));
  file->exr = NULL;
  HETAB_TRY(outcome(ctx, file));
  return apply_patches(ctx, file);
}

/* What the library still holds back goes nowhere, as after a failed write. */
void hetab_exr_file_free(hetab_exr_file *file) {
  if (!file)
    return;
  if (!file->error)
    file->error = ECANCELED;
  if (file->exr)
    exr_finish(&file->exr);
  free(file);
}
