#include "table/specular_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

char *hetab_specular_path(hetab_context *ctx, const char *path) {
  char *name;
  const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
  int stem = (int)(dot && (!slash || dot > slash) ? (size_t)(dot - path) : strlen(path));
  if (asprintf(&name, "%.*s.specular.csv", stem, path) >= 0)
    return name;
  hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for the name of '%s'", path);
  return NULL;
}

hetab_status hetab_specular_save(hetab_context *ctx, const char *path, const double *lambda_um,
                                 size_t count, const double *rho, int overwrite) {
  char *text = NULL;
  size_t size;
  FILE *stream = open_memstream(&text, &size);
  if (!stream)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for '%s'", path);
  fputs("wavelength_nm,theta_i_deg,rho_s\n", stream);
  for (size_t w = 0; w < count; w++)
    for (int i = 0; i < HETAB_SPECULAR_ANGLES; i++)
      fprintf(stream, "%.10g,%d,%.9g\n", 1000 * lambda_um[w], i,
              rho[w * HETAB_SPECULAR_ANGLES + (size_t)i]);
  hetab_status status = fclose(stream) == 0
                            ? hetab_text_save(ctx, path, text, size, overwrite)
                            : hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory for '%s'", path);
  free(text);
  return status;
}
