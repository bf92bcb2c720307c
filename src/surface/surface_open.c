/* Surfaces by name or by file. */
#include <string.h>

#include "core/text.h"
#include "surface/surface_parts.h"

hetab_status hetab_surface_open(hetab_context *ctx, const char *name_or_path, hetab_surface **out) {
  if (strchr(name_or_path, '/') || hetab_has_extension(name_or_path, hetab_yaml_extensions))
    return hetab_surface_load(ctx, name_or_path, out);
  return hetab_surface_preset(ctx, name_or_path, out);
}
