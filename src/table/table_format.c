#include "table/table_format.h"

#include <string.h>
#include <strings.h>

#include <hetab/merl.h>
#include <hetab/table.h>

#include "core/input_file.h"

hetab_status hetab_format_of(hetab_context *ctx, const char *path, hetab_format *out) {
  static const unsigned char h5_start[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
  unsigned char start[12];
  HETAB_TRY(hetab_input_start(ctx, path, HETAB_INPUT_TABLE, start, sizeof start));
  if (memcmp(start, h5_start, sizeof h5_start) == 0)
    *out = HETAB_FORMAT_H5;
  else if (memcmp(start, "tensor_file", sizeof start) == 0)
    *out = HETAB_FORMAT_RGL;
  else if (start[0] == HETAB_MERL_THETA_H || start[3] == HETAB_MERL_THETA_H) /* either order */
    *out = HETAB_FORMAT_MERL;
  else
    return hetab_fail(ctx, HETAB_ERR_PARSE,
                      "'%s' is no table: neither HDF5 (.h5), MERL (.binary) nor RGL (.bsdf)", path);
  return HETAB_OK;
}

int hetab_format_by_ending(const char *path, hetab_format *out) {
  static const struct {
    const char *ending;
    hetab_format format;
  } endings[] = {{".h5", HETAB_FORMAT_H5},
                 {".hdf5", HETAB_FORMAT_H5},
                 {".exr", HETAB_FORMAT_EXR},
                 {".binary", HETAB_FORMAT_MERL},
                 {".bsdf", HETAB_FORMAT_RGL}};
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path,
             *dot = strrchr(name, '.');
  for (size_t i = 0; dot && dot > name && i < sizeof endings / sizeof *endings; i++)
    if (strcasecmp(dot, endings[i].ending) == 0) {
      *out = endings[i].format;
      return 1;
    }
  return 0;
}
