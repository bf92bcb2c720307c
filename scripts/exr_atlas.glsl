// The BRDF of an atlas (hetab tabulate SURFACE -o FILE.exr --exr-layout atlas) in a shader: GLSL 1.30
// and later, GLSL ES 3.00 (WebGL 2) with highp floats and samplers.
//
// Trilinear between the nodes of theta_i, theta_r and phi, beyond the first and the last their values.
// By hand, of texels: a texture's own filter would mix tiles, and has weights of 8 bits. Within 5e-5 of
// the same sum in double, relative to the largest of the 8 values (tests/renderers/atlas.py); what
// that is of the model, `hetab tabulate` says: readers that interpolate linearly. Half adds 0.05 %, or 3e-8.
// The delta is not in it: its weights by theta_i are the attributes specular_reflectance_R, _G, _B.
uniform sampler2D atlas;       // RGB16F or RGB32F; the file's first row is row 0 (no flip)
uniform ivec4 atlas_count;     // of theta_i_deg, theta_r_deg, phi_deg; and tiles_across
uniform vec3 atlas_first;      // the first of theta_i_deg, theta_r_deg, phi_deg
uniform vec3 atlas_per_degree; // (count - 1) / (last - first), 0 where count is 1; equal steps alone

// Of the nodes theta_i, theta_r, phi.
vec3 atlas_node(ivec3 node) {
  ivec2 tile = ivec2(node.x % atlas_count.w, node.x / atlas_count.w);
  return texelFetch(atlas, tile * atlas_count.zy + node.zy, 0).rgb;
}

// In 1/sr and linear sRGB (negative beyond its gamut), without a cosine. Radians; phi is the viewer's
// azimuth minus the light's, any: pi is the mirror side.
vec3 atlas_brdf(float theta_i, float theta_r, float phi) {
  const float pi = 3.14159265;
  vec3 angles = degrees(vec3(theta_i, theta_r, abs(mod(phi + pi, 2.0 * pi) - pi)));
  ivec3 last = atlas_count.xyz - 1;
  vec3 at = clamp((angles - atlas_first) * atlas_per_degree, vec3(0.0), vec3(last));
  ivec3 node = ivec3(at);
  vec3 part = at - vec3(node), sum = vec3(0.0);
  for (int corner = 0; corner < 8; corner++) {
    ivec3 high = ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
    vec3 weight = mix(1.0 - part, part, vec3(high));
    sum += weight.x * weight.y * weight.z * atlas_node(min(node + high, last));
  }
  return sum;
}
