#include "table/table_format.h"

#include <string.h>
#include <strings.h>

#include <hetab/merl.h>
#include <hetab/table.h>

#include "core/input_file.h"

static const struct {
  const char *name, *word, *endings[2];
  unsigned char start[HETAB_FORMAT_START]; /* up to its length */
  size_t length;
} formats[] = {
    [HETAB_FORMAT_H5] =
        {"HDF5", "hdf5", {".h5", ".hdf5"}, {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'}, 8},
    [HETAB_FORMAT_MERL] = {"MERL", "merl", {".binary"}, {HETAB_MERL_THETA_H}, 4},
    [HETAB_FORMAT_RGL] = {"RGL", "rgl", {".bsdf"}, HETAB_RGL_SIGNATURE, sizeof HETAB_RGL_SIGNATURE},
    [HETAB_FORMAT_EXR] = {"OpenEXR", "exr", {".exr"}, {0x76, 0x2f, 0x31, 0x01}, 4},
};
enum { FORMATS = sizeof formats / sizeof *formats };

const char *hetab_format_name(hetab_format format) {
  return formats[format].name;
}

const char *hetab_format_word(hetab_format format) {
  return formats[format].word;
}

bool hetab_format_by_start(const unsigned char start[HETAB_FORMAT_START], hetab_format *out) {
  static const unsigned char big_endian[4] = {0, 0, 0, HETAB_MERL_THETA_H};
  for (int f = 0; f < FORMATS; f++)
    if (memcmp(start, formats[f].start, formats[f].length) == 0 ||
        (f == HETAB_FORMAT_MERL && memcmp(start, big_endian, sizeof big_endian) == 0)) {
      *out = (hetab_format)f;
      return true;
    }
  return false;
}

hetab_status hetab_format_of(hetab_context *ctx, const char *path, hetab_format *out) {
  unsigned char start[HETAB_FORMAT_START];
  HETAB_TRY(hetab_input_start(ctx, path, HETAB_INPUT_TABLE, start, sizeof start));
  if (hetab_format_by_start(start, out) && *out != HETAB_FORMAT_EXR)
    return HETAB_OK;
  if (memcmp(start, (unsigned char[HETAB_FORMAT_START]){0}, sizeof start) == 0)
    return hetab_fail(ctx, HETAB_ERR_PARSE,
                      "'%s' is empty, or begins with zeros: get a complete copy", path);
  return hetab_fail(ctx, HETAB_ERR_PARSE,
                    "'%s' is no table: neither HDF5 (.h5), MERL (.binary) nor RGL (.bsdf)", path);
}

int hetab_format_by_ending(const char *path, hetab_format *out) {
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path,
             *dot = strrchr(name, '.');
  for (int i = 0; dot && dot > name && i < 2 * FORMATS; i++)
    if (formats[i / 2].endings[i % 2] && strcasecmp(dot, formats[i / 2].endings[i % 2]) == 0) {
      *out = (hetab_format)(i / 2);
      return 1;
    }
  return 0;
}
