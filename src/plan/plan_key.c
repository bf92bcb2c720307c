#include "plan/plan_key.h"

#include <stdio.h>
#include <stdlib.h>

#include "core/context.h"
#include "core/md5.h"
#include "plan/scene.h"

static hetab_status digest(hetab_context *ctx, FILE *stream, char **text, const size_t *size,
                           char key[HETAB_KEY]) {
  hetab_status status = HETAB_OK;
  if (fclose(stream) == 0)
    hetab_md5(*text, *size, key);
  else
    status = hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
  free(*text);
  return status;
}

hetab_status hetab_surface_key(hetab_context *ctx, const hetab_scene *scene, size_t i,
                               char key[HETAB_KEY]) {
  const hetab_surface *s = scene->surfaces[i];
  char *text = NULL;
  size_t size;
  FILE *stream = open_memstream(&text, &size);
  if (!stream)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
  fprintf(stream, "%s %s %a %a %d %a %a", hetab_version(), hetab_surface_name(s),
          hetab_surface_sigma0_um(s), hetab_surface_tau_um(s), (int)scene->consumer,
          scene->max_theta_i, scene->max_theta_r);
  fwrite(hetab_surface_bands(s), sizeof(hetab_band), hetab_surface_band_count(s), stream);
  return digest(ctx, stream, &text, &size, key);
}

hetab_status hetab_scene_key(hetab_context *ctx, const hetab_scene *scene, char key[HETAB_KEY]) {
  char *text = NULL, one[HETAB_KEY];
  size_t size;
  hetab_status status = HETAB_OK;
  FILE *stream = open_memstream(&text, &size);
  if (!stream)
    return hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
  fprintf(stream, "%a %a %a %a", scene->table_error, scene->energy_error, scene->specular_cone,
          scene->memory_bytes);
  for (size_t i = 0; i < scene->count && status == HETAB_OK; i++) {
    status = hetab_surface_key(ctx, scene, i, one);
    fprintf(stream, " %s", one);
  }
  hetab_status last = digest(ctx, stream, &text, &size, key);
  return status == HETAB_OK ? last : status;
}

hetab_status hetab_item_key(hetab_context *ctx, const hetab_scene *scene, const hetab_plan *plan,
                            size_t i, char key[HETAB_KEY]) {
  const hetab_plan_item *item = &plan->items[i];
  char text[512], of_surface[HETAB_KEY];
  HETAB_TRY(hetab_surface_key(ctx, scene, i, of_surface));
  int length =
      snprintf(text, sizeof text, "%s %d %d %a %s %zu %zu %zu %a %a", of_surface, (int)item->kind,
               (int)item->delta, scene->specular_cone,
               hetab_surface_name(scene->surfaces[item->shares]), item->wavelengths,
               item->theta_i_count, item->resolution, item->spacing_deg, plan->table_error);
  hetab_md5(text, (size_t)length, key);
  return HETAB_OK;
}
