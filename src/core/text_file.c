#include <hetab/output_file.h>

#include "core/context.h"
#include "core/atomic_file.h"

hetab_status hetab_output_check(hetab_context *ctx, const char *path, int overwrite) {
  hetab_atomic_file *file;
  HETAB_TRY(hetab_atomic_create(ctx, path, overwrite, &file));
  hetab_atomic_abort(file);
  return HETAB_OK;
}

hetab_status hetab_text_save(hetab_context *ctx, const char *path, const char *text, size_t size,
                             int overwrite) {
  hetab_atomic_file *file;
  hetab_status status;
  HETAB_TRY(hetab_atomic_create(ctx, path, overwrite, &file));
  HETAB_GOTO(hetab_atomic_write(ctx, file, text, size));
  return hetab_atomic_commit(ctx, file);
done:
  hetab_atomic_abort(file);
  return status;
}
