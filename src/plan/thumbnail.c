#include "plan/thumbnail.h"

#include <math.h>
#include <stdlib.h>
#include <png.h>

#include "core/context.h"

enum { SIDE = 56, LIGHTS = 7 };

/* From the left above, and a ring of weaker ones that stand for a bright room; z is to the viewer.
 */
static const float lights[LIGHTS][4] = {{-0.5f, 0.6f, 0.62f, 1.6f},    {0.9f, 0.0f, 0.43f, 0.5f},
                                        {0.45f, 0.78f, 0.43f, 0.5f},   {-0.9f, 0.0f, 0.43f, 0.5f},
                                        {-0.45f, -0.78f, 0.43f, 0.4f}, {0.45f, -0.78f, 0.43f, 0.4f},
                                        {0.0f, 0.0f, 1.0f, 0.5f}};

static void channels_of(const hetab_rgl *rgl, size_t rgb[3]) {
  static const double shown_um[3] = {0.65, 0.55, 0.45};
  const double *lambda_um = hetab_rgl_wavelengths_um(rgl);
  for (size_t c = 0; c < 3; c++) {
    rgb[c] = lambda_um ? 0 : c;
    for (size_t w = 0; lambda_um && w < hetab_rgl_channel_count(rgl); w++)
      if (fabs(lambda_um[w] - shown_um[c]) < fabs(lambda_um[rgb[c]] - shown_um[c]))
        rgb[c] = w;
  }
}

/* v in a frame whose z is n. */
static void to_frame(const float n[3], const float v[3], float out[3]) {
  float sign = n[2] >= 0.0f ? 1.0f : -1.0f, a = -1.0f / (sign + n[2]), b = n[0] * n[1] * a;
  const float s[3] = {1.0f + sign * n[0] * n[0] * a, sign * b, -sign * n[0]};
  const float t[3] = {b, sign + n[1] * n[1] * a, -n[1]};
  out[0] = s[0] * v[0] + s[1] * v[1] + s[2] * v[2];
  out[1] = t[0] * v[0] + t[1] * v[1] + t[2] * v[2];
  out[2] = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
}

static unsigned char to_byte(float linear) {
  float x = linear / (1.0f + linear); /* lobes are far brighter than what is around them */
  float srgb = x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1.0f / 2.4f) - 0.055f;
  return (unsigned char)(255.0f * fminf(fmaxf(srgb, 0.0f), 1.0f) + 0.5f);
}

static void shade(const hetab_rgl *rgl, const size_t rgb[3], const float n[3], float *value,
                  unsigned char *pixel) {
  static const float view[3] = {0.0f, 0.0f, 1.0f};
  float sum[3] = {0}, wi[3], wo[3];
  to_frame(n, view, wo);
  for (int l = 0; l < LIGHTS; l++) {
    to_frame(n, lights[l], wi);
    if (wi[2] <= 0.0f)
      continue;
    hetab_rgl_eval(rgl, wi, wo, value);
    for (int c = 0; c < 3; c++)
      sum[c] += value[rgb[c]] * wi[2] * lights[l][3];
  }
  for (int c = 0; c < 3; c++)
    pixel[c] = to_byte(sum[c]);
  pixel[3] = 255;
}

static char *base64(hetab_context *ctx, const unsigned char *data, size_t size) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  char *text = hetab_alloc(ctx, (size + 2) / 3 * 4 + 1, 1), *at = text;
  for (size_t i = 0; text && i < size; i += 3) {
    unsigned bits = (unsigned)data[i] << 16 | (i + 1 < size ? (unsigned)data[i + 1] << 8 : 0) |
                    (i + 2 < size ? data[i + 2] : 0);
    for (int d = 0; d < 4; d++)
      *at++ = i + (size_t)d <= size ? digits[bits >> (18 - 6 * d) & 63] : '=';
  }
  return text;
}

static char *encode(hetab_context *ctx, const unsigned char *pixels) {
  png_image image = {
      .version = PNG_IMAGE_VERSION, .width = SIDE, .height = SIDE, .format = PNG_FORMAT_RGBA};
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  HETAB_FREED unsigned char *file = hetab_alloc(ctx, size, 1);
  char *text = NULL;
  if (file && png_image_write_to_memory(&image, file, &size, 0, pixels, 0, NULL))
    text = base64(ctx, file, size);
  return text;
}

char *hetab_thumbnail(hetab_context *ctx, const hetab_rgl *rgl) {
  HETAB_FREED unsigned char *pixels = hetab_alloc(ctx, SIDE * SIDE, 4);
  HETAB_FREED float *value = hetab_alloc(ctx, hetab_rgl_channel_count(rgl), sizeof *value);
  size_t rgb[3];
  channels_of(rgl, rgb);
  for (int y = 0; pixels && value && y < SIDE; y++)
    for (int x = 0; x < SIDE; x++) {
      float u = (2.0f * (float)x + 1.0f) / SIDE - 1.0f, v = 1.0f - (2.0f * (float)y + 1.0f) / SIDE;
      float z2 = 1.0f - u * u - v * v;
      if (z2 > 0.0f)
        shade(rgl, rgb, (float[]){u, v, sqrtf(z2)}, value, pixels + 4 * (y * SIDE + x));
    }
  return pixels && value ? encode(ctx, pixels) : NULL;
}
