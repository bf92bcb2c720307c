#include <openexr.h>

#include "core/context.h"
#include "table/exr_file.h"

static void ignore_error(exr_const_context_t exr, exr_result_t code, const char *message) {}

/* The places of all chunks of a part. */
static exr_result_t check_part(exr_const_context_t exr, int part) {
  exr_attr_box2i_t window;
  exr_chunk_info_t chunk;
  int32_t lines;
  exr_result_t result = exr_get_data_window(exr, part, &window);
  if (result == EXR_ERR_SUCCESS)
    result = exr_get_scanlines_per_chunk(exr, part, &lines);
  for (int y = window.min.y; result == EXR_ERR_SUCCESS && y <= window.max.y; y += lines)
    result = exr_read_scanline_chunk_info(exr, part, y, &chunk);
  return result;
}

hetab_status hetab_exr_file_check(hetab_context *ctx, const char *path, size_t part_count) {
  exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
  exr_context_t exr = NULL;
  int count = 0;
  start.error_handler_fn = ignore_error;
  exr_result_t result = exr_start_read(&exr, path, &start);
  if (result == EXR_ERR_SUCCESS)
    result = exr_get_count(exr, &count);
  for (int i = 0; i < count && result == EXR_ERR_SUCCESS; i++)
    result = check_part(exr, i);
  if (exr)
    exr_finish(&exr);
  if (result == EXR_ERR_SUCCESS && (size_t)count == part_count)
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_PARSE, "'%s': %d of %zu OpenEXR parts: %s", path, count,
                    part_count, exr_get_error_code_as_string(result));
}
