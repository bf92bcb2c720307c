/* Surfaces by name or by file. */
#include <string.h>
#include <sys/stat.h>

#include "core/text.h"
#include "surface/surface_parts.h"

hetab_status hetab_surface_open(hetab_context *ctx, const char *name_or_path, hetab_surface **out) {
  if (strchr(name_or_path, '/') || hetab_has_extension(name_or_path, hetab_yaml_extensions))
    return hetab_surface_load(ctx, name_or_path, out);
  hetab_status status = hetab_surface_preset(ctx, name_or_path, out);
  struct stat about;
  if (status == HETAB_ERR_ARGUMENT && stat(name_or_path, &about) == 0)
    return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                      "%s is %s, no surface: give a preset ('hetab surfaces' lists them) or a file "
                      "ending in .yml or .yaml",
                      name_or_path, S_ISDIR(about.st_mode) ? "a folder" : "a file of another kind");
  return status;
}
