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
@glsl.inc@
