/* A view as a PNG page or as OpenEXR data. */
#include <math.h>
#include <stdlib.h>
#include <png.h>

#include <hetab/table.h>

#include "core/angle.h"
#include "core/context.h"
#include "table/exr_file.h"
#include "view/view_parts.h"

/* ---- PNG ----------------------------------------------------------------------------------- */

static unsigned char to_byte(float value) {
  return (unsigned char)(fmin(fmax((double)value, 0), 1) * 255 + 0.5);
}

static void to_bytes(const hetab_canvas *page, unsigned char *bytes) {
  for (size_t i = 0; i < (size_t)page->width * (size_t)page->height; i++) {
    *bytes++ = to_byte(page->pixels[i].r);
    *bytes++ = to_byte(page->pixels[i].g);
    *bytes++ = to_byte(page->pixels[i].b);
  }
}

/* The file's bytes; free() them. */
static hetab_status encode(hetab_context *ctx, const hetab_canvas *page, void **out, size_t *size) {
  png_image image = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)page->width,
                     .height = (png_uint_32)page->height,
                     .format = PNG_FORMAT_RGB};
  png_alloc_size_t most = PNG_IMAGE_PNG_SIZE_MAX(image);
  HETAB_FREED unsigned char *bytes =
      hetab_alloc(ctx, (size_t)page->width * (size_t)page->height, 3);
  *out = bytes ? hetab_alloc(ctx, most, 1) : NULL;
  hetab_status status = *out ? HETAB_OK : HETAB_ERR_MEMORY;
  if (status == HETAB_OK) {
    to_bytes(page, bytes);
    if (!png_image_write_to_memory(&image, *out, &most, 0, bytes, 0, NULL))
      status = hetab_fail(ctx, HETAB_ERR_IO, "cannot make a PNG of the view: %s", image.message);
  }
  *size = most;
  return status;
}

hetab_status hetab_view_save_png(hetab_context *ctx, const hetab_view *view, const char *path,
                                 int overwrite) {
  HETAB_ENDS(hetab_canvas_clear) hetab_canvas page = {0};
  HETAB_FREED void *file = NULL;
  size_t size;
  HETAB_TRY(hetab_page_draw(ctx, view, &page));
  HETAB_TRY(encode(ctx, &page, &file, &size));
  return hetab_text_save(ctx, path, file, size, overwrite);
}

/* ---- OpenEXR ------------------------------------------------------------------------------- */

enum { MOST_PARTS = 1 + 2 * HETAB_VIEW_MOST_THETA_I, MOST_CHANNELS = 4 };

static const char *const channels[MOST_CHANNELS] = {"R", "G", "B", "theta_r_deg"};

/* A picture as a part. */
typedef struct layer {
  char name[HETAB_EXR_NAME];
  size_t width, height;
  float (*rgb)[3];
  float *theta_r_deg; /* lobes */
} layer;

static size_t list_layers(const hetab_view *view, layer layers[MOST_PARTS]) {
  double theta_i_deg[HETAB_VIEW_MOST_THETA_I];
  size_t count = 0;
  for (size_t i = 0; i < view->theta_i_count; i++)
    theta_i_deg[i] = hetab_degrees(view->theta_i[i]);
  if (view->sphere)
    layers[count++] = (layer){"sphere", view->sphere_side, view->sphere_side, view->sphere, NULL};
  for (size_t i = 0; i < view->theta_i_count; i++)
    if (view->maps[i]) {
      layers[count] = (layer){"", view->map_side, view->map_side, view->maps[i], NULL};
      hetab_exr_part_name("map_theta_i_", "deg", theta_i_deg, view->theta_i_count, i,
                          layers[count++].name);
    }
  for (size_t i = 0; i < view->theta_i_count; i++)
    if (view->lobes[i]) {
      layers[count] = (layer){"", HETAB_LOBE_POINTS, 1, view->lobes[i], view->lobe_theta_r_deg[i]};
      hetab_exr_part_name("lobe_theta_i_", "deg", theta_i_deg, view->theta_i_count, i,
                          layers[count++].name);
    }
  return count;
}

static hetab_exr_part part_of(const layer *l) {
  return (hetab_exr_part){.name = l->name,
                          .width = (int)l->width,
                          .height = (int)l->height,
                          .channels = channels,
                          .channel_count = l->theta_r_deg ? 4 : 3};
}

static hetab_status write_layer(hetab_context *ctx, hetab_exr_file *file, int number,
                                const layer *l) {
  hetab_exr_part part = part_of(l);
  size_t count = l->width * l->height;
  const float *planes[MOST_CHANNELS];
  HETAB_FREED float *memory = hetab_alloc(ctx, 3 * count, sizeof *memory);
  HETAB_NEED(memory);
  for (size_t i = 0; i < 3 * count; i++)
    memory[i % 3 * count + i / 3] = l->rgb[i / 3][i % 3];
  for (size_t c = 0; c < 3; c++)
    planes[c] = memory + c * count;
  planes[3] = l->theta_r_deg;
  return hetab_exr_file_write(ctx, file, number, &part, planes);
}

static void add_layer(hetab_exr_file *file, const hetab_view *view, const layer *l,
                      const layer *first) {
  hetab_exr_part part = part_of(l);
  hetab_exr_file_part(file, &part, (int)first->width, (int)first->height);
  hetab_exr_put_text(file, "surface", view->title);
  hetab_exr_put_text(file, "description", view->subtitle);
  hetab_exr_put_text(file, "units", l->rgb == view->sphere ? "radiance" : "1/sr");
  hetab_exr_put_text(file, "hetab_version", hetab_version());
  hetab_exr_put_chromaticities(file);
}

static hetab_status write_layers(hetab_context *ctx, hetab_exr_file *file, const hetab_view *view,
                                 const layer *layers, size_t count) {
  for (size_t i = 0; i < count; i++)
    add_layer(file, view, &layers[i], &layers[0]);
  HETAB_TRY(hetab_exr_file_begin(ctx, file));
  for (size_t i = 0; i < count; i++)
    HETAB_TRY(write_layer(ctx, file, (int)i, &layers[i]));
  return hetab_exr_file_finish(ctx, file);
}

hetab_status hetab_view_save_exr(hetab_context *ctx, const hetab_view *view, const char *path,
                                 int overwrite) {
  layer layers[MOST_PARTS];
  hetab_atomic_file *atomic;
  hetab_exr_file *file = NULL;
  size_t count = list_layers(view, layers);
  HETAB_TRY(hetab_atomic_create(ctx, path, overwrite, &atomic));
  hetab_status status = hetab_exr_file_create(ctx, atomic, &file);
  if (status == HETAB_OK)
    status = write_layers(ctx, file, view, layers, count);
  hetab_exr_file_free(file);
  if (status == HETAB_OK)
    return hetab_atomic_commit(ctx, atomic);
  hetab_atomic_abort(atomic);
  return status;
}
