/* Indices of files: the reader is chosen by the file's ending. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "core/text.h"
#include "surface/index_parts.h"

hetab_status hetab_index_load(hetab_context *ctx, const char *path, hetab_index **out) {
  *out = NULL;
  char *absolute = realpath(path, NULL);
  if (!absolute)
    return hetab_fail(ctx, HETAB_ERR_IO, "%s: cannot open: %s: check the path", path,
                      strerror(errno));
  hetab_index *index;
  hetab_status status = hetab_index_new(ctx, HETAB_INDEX_FILE, absolute, &index);
  free(absolute);
  HETAB_TRY(status);
  status = hetab_has_extension(path, hetab_yaml_extensions)
               ? hetab_index_read_yaml(ctx, path, index)
               : hetab_index_read_csv(ctx, path, index);
  *out = index;
  HETAB_MADE(hetab_index, out, status);
}
