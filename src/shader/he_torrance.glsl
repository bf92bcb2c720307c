/* The He-Torrance reflectance model, whole, for GLSL ES 3.00 and later. Written by hetab @VERSION@.
 *
 * @ERROR@
 *
 *   float f = ht_brdf(ht_surface(sigma0_um, tau_um, lambda_um, n, k, diffuse_reflectance),
 *                     wi.x, wi.y, wi.z, wo.x, wo.y, wo.z);
 *
 * ht_table is a texture of @COUNT@ - 3 by @COUNT@ + 1 texels in RGBA32F (NEAREST, no mipmaps): texel (i, j) is numbers
 * i to i + 3 of row j of the table, float32, little-endian, in rows of @COUNT@, in base64:
 * ht_table = @TABLE@
 *
 * The surface that this file was made for, and n and k of the built-in metals at 400, 410 ... 700
 * nm, as JSON:
@data.json@ */
precision highp float;
precision highp int;

uniform highp sampler2D ht_table;

#define HT_FN
#define HT_CONST const
#define HT_INT(x) int(x)
#define ht_four vec4
#define ht_sqrt sqrt
#define ht_exp exp
#define ht_log log
#define ht_cos cos
#define ht_sin sin
#define ht_floor floor
#define ht_abs abs
#define ht_min min
#define ht_max max

vec4 ht_run(int row, int column) {
  return texelFetch(ht_table, ivec2(column, row), 0);
}

@model.inc@
