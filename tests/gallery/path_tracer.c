/* A small path tracer: a floor and spheres, a table each, a lamp and a sky.
 * usage: path_tracer OUT.png SAMPLES FLOOR SPHERE... (tables of linear sRGB: .binary or .bsdf)
 * SAMPLES of a pixel are spread evenly, most so a power of 2.
 * cc -O2 -fopenmp path_tracer.c $(pkg-config --cflags --libs hetab libpng) -lm */
#include <math.h>
#include <png.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <hetab/lookup.h>

typedef float vec __attribute__((vector_size(16)));
enum { WIDTH = 1680, HEIGHT = 540, MOST = 9, FLOOR = 0, LAMP = MOST, SKY, DEPTH = 8 };
static hetab_lookup *tables[MOST];
static int count;
static const vec lamp = {-1.5f, -3, 7}, lamp_light = {22, 20, 17}, half = {3, 1, 0}; /* its sides */
static const float lamp_area = 12;

static float dot(vec a, vec b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static vec unit(vec a) {
  return a / sqrtf(dot(a, a));
}
/* Sobol's points, shuffled and scrambled (Burley 2020): the next pair of dimensions of a sample. */
typedef struct samples {
  uint32_t index, seed; /* of the sample; of its pixel and dimensions */
} samples;
static uint32_t reverse(uint32_t v) {
  v = (v >> 1 & 0x55555555u) | (v & 0x55555555u) << 1;
  v = (v >> 2 & 0x33333333u) | (v & 0x33333333u) << 2;
  v = (v >> 4 & 0x0f0f0f0fu) | (v & 0x0f0f0f0fu) << 4;
  return __builtin_bswap32(v);
}
static uint32_t scramble(uint32_t v, uint32_t seed) {
  v = reverse(v) + seed;
  v ^= v * 0x6c50b47cu;
  v ^= v * 0xb82f1e52u;
  v ^= v * 0xc7afe638u;
  v ^= v * 0x8d22f6e6u;
  return reverse(v);
}
static void next_pair(samples *s, float u[2]) {
  uint32_t second = 0, bit = 1u << 31;
  s->seed = s->seed * 0x2c1b3c6du + 0x297a2d39u;
  uint32_t hash = (s->seed ^ s->seed >> 16) * 0x45d9f3bu, index = scramble(s->index, hash);
  for (uint32_t i = index; i; i >>= 1, bit ^= bit >> 1)
    second ^= i & 1 ? bit : 0;
  u[0] = (float)(scramble(reverse(index), hash * 0x9e3779b9u) >> 8) * 0x1p-24f;
  u[1] = (float)(scramble(second, hash * 0x85ebca6bu) >> 8) * 0x1p-24f;
}
static vec sky(vec d) {
  float t = sqrtf(fmaxf(d[2], 0));
  return (vec){0.7f, 0.76f, 0.86f} * (1 - t) + (vec){0.16f, 0.26f, 0.48f} * t;
}

/* What the ray meets first, a little above where, and the normal there. */
static int meet(vec o, vec d, vec *p, vec *n) {
  float nearest = d[2] < 0 ? -o[2] / d[2] : 1e9f, t = (lamp[2] - o[2]) / d[2];
  int object = d[2] < 0 ? FLOOR : SKY;
  *n = (vec){0, 0, 1};
  vec across = o + d * t - lamp;
  if (t > 0 && t < nearest && fabsf(across[0]) < half[0] && fabsf(across[1]) < half[1])
    object = LAMP, nearest = t;
  for (int i = 1; i < count; i++) {
    vec c = o - (vec){2.3f * ((float)i - 0.5f * (float)count), 0, 1};
    float b = dot(c, d), under = b * b - dot(c, c) + 1;
    t = -b - sqrtf(fmaxf(under, 0));
    if (under > 0 && t > 0 && t < nearest)
      object = i, nearest = t, *n = unit(c + d * t);
  }
  *p = o + d * nearest + *n * 1e-4f;
  return object;
}

static vec trace(vec o, vec d, samples *random) {
  vec sum = {0}, through = {1, 1, 1}, p, n, q, m;
  float density = 0; /* of d; 0: from the camera or a mirror, where the lamp is not sampled */
  for (int depth = 0; depth < DEPTH; depth++) {
    int object = meet(o, d, &p, &n);
    if (object == SKY)
      return sum + through * sky(d);
    if (object == LAMP) { /* multiple importance sampling, power heuristic */
      float by_lamp = dot(p - o, p - o) / (lamp_area * fabsf(d[2]));
      float share = density > 0 ? 1 / (1 + by_lamp * by_lamp / (density * density)) : 1;
      return d[2] > 0 ? sum + through * lamp_light * share : sum;
    }
    vec x = unit(fabsf(n[0]) > 0.5f ? (vec){n[2], 0, -n[0]} : (vec){0, n[2], -n[1]});
    vec y = {n[1] * x[2] - n[2] * x[1], n[2] * x[0] - n[0] * x[2], n[0] * x[1] - n[1] * x[0]};
    float wi[3] = {-dot(x, d), -dot(y, d), -dot(n, d)}, f[3];

    float at[2], u[2], uc[2];
    next_pair(random, at);
    vec to = lamp + half * (vec){2 * at[0] - 1, 2 * at[1] - 1} - p;
    vec towards = unit(to);
    if (dot(towards, n) > 0 && meet(p, towards, &q, &m) == LAMP) {
      float at_lamp[3] = {dot(x, towards), dot(y, towards), dot(n, towards)};
      float by_lamp = dot(to, to) / (lamp_area * fabsf(towards[2])), by_table;
      hetab_lookup_eval(tables[object], NULL, 1, wi, at_lamp, f, &by_table);
      sum += through * (vec){f[0], f[1], f[2]} * lamp_light * at_lamp[2] * by_lamp /
             (by_lamp * by_lamp + by_table * by_table);
    }

    hetab_lookup_drawn drawn;
    next_pair(random, uc);
    next_pair(random, u);
    hetab_lookup_sample(tables[object], NULL, 1, wi, uc, u, &drawn, f);
    if (drawn.lobe == HETAB_LOOKUP_NONE)
      return sum;
    through *= (vec){f[0], f[1], f[2]};
    density = drawn.lobe == HETAB_LOOKUP_SPECULAR ? 0 : drawn.pdf;
    o = p;
    d = unit(x * drawn.wo[0] + y * drawn.wo[1] + n * drawn.wo[2]);
  }
  return sum;
}

static uint8_t encode(float v) { /* a shoulder for what is brighter than white, and sRGB's curve */
  v = 1 - expf(-1.5f * v);
  return (uint8_t)(255 * (v < 0.0031308f ? 12.92f * v : 1.055f * powf(v, 1 / 2.4f) - 0.055f) +
                   0.5f);
}

int main(int argc, char **argv) {
  static uint8_t picture[HEIGHT][WIDTH][3];
  const vec eye = {0, -15, 4.2f}, ahead = unit((vec){0, 0, 0.85f} - eye);
  png_image image = {.version = PNG_IMAGE_VERSION, .width = WIDTH, .height = HEIGHT};
  hetab_context *ctx;
  int per_pixel = argc > 4 ? atoi(argv[2]) : 0;
  if (per_pixel < 1 || argc - 3 > MOST || hetab_context_create(&ctx) != HETAB_OK)
    return fprintf(stderr, "usage: path_tracer OUT.png SAMPLES FLOOR SPHERE...\n"), 2;
  for (; count < argc - 3; count++)
    if (hetab_lookup_open(ctx, argv[3 + count], HETAB_LOOKUP_INTERPOLATE, &tables[count]) ||
        hetab_lookup_channel_count(tables[count]) != 3)
      return fprintf(stderr, "%s: no linear sRGB: %s\n", argv[3 + count], hetab_error_message(ctx));
#pragma omp parallel for schedule(dynamic)
  for (int i = 0; i < HEIGHT * WIDTH; i++) {
    vec light = {0};
    for (int s = 0; s < per_pixel; s++) {
      samples random = {(uint32_t)s, scramble((uint32_t)i, 0x9e3779b9u)};
      float u[2];
      next_pair(&random, u);
      float x = ((float)(i % WIDTH) + u[0]) / WIDTH - 0.5f;
      float y = (0.5f * HEIGHT - (float)(i / WIDTH) - u[1]) / WIDTH;
      vec d = unit(ahead + (vec){x, -ahead[2] * y, ahead[1] * y} * 1.15f);
      vec one = trace(eye, d, &random); /* less of a caustic's stray sparks */
      light += one / (float)per_pixel * fminf(1, 6 / (one[0] + one[1] + one[2] + 1e-9f));
    }
    for (int c = 0; c < 3; c++)
      picture[i / WIDTH][i % WIDTH][c] = encode(light[c]);
  }
  for (int i = 0; i < count; i++)
    hetab_lookup_free(tables[i]);
  hetab_context_free(ctx);
  image.format = PNG_FORMAT_RGB;
  return !png_image_write_to_file(&image, argv[1], 0, picture, 0, NULL);
}
