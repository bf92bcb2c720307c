#include "convert/read_back.h"

#include <hetab/merl.h>
#include <hetab/rgl.h>
#include <hetab/table.h>

#include "table/exr_file.h"

hetab_status hetab_read_back(hetab_context *ctx, hetab_format format, const char *path,
                             size_t exr_parts) {
  hetab_h5_table *h5 = NULL;
  hetab_merl *merl = NULL;
  hetab_rgl *rgl = NULL;
  hetab_status status = format == HETAB_FORMAT_H5     ? hetab_h5_open(ctx, path, &h5)
                        : format == HETAB_FORMAT_MERL ? hetab_merl_load(ctx, path, &merl)
                        : format == HETAB_FORMAT_RGL  ? hetab_rgl_load(ctx, path, &rgl)
                                                      : hetab_exr_file_check(ctx, path, exr_parts);
  hetab_h5_free(h5);
  hetab_merl_free(merl);
  hetab_rgl_free(rgl);
  return status;
}
