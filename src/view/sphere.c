/* The lit sphere. Lights are distant and the viewer is too, so that a pixel is a normal; the BRDF
 * comes from a lobe table over the viewer's angle. */
#include <math.h>
#include <stdlib.h>

#include "core/context.h"
#include "view/pictures.h"

/* Angles of the viewer in the table, and nodes of the dome's integrals. */
enum { ANGLES = 24, DOME_RAYS = 24, DOME_NODES = 48 };
enum { RINGS = 5, DISC = 1 + 3 * RINGS * (RINGS + 1) };

static const double pi = 3.14159265358979323846;

static const hetab_lobe_size table_size = {17, 56};

typedef struct vec {
  double x, y, z;
} vec;

typedef struct lamp {
  vec to;            /* unit */
  double irradiance; /* facing it */
  double radius;     /* radians */
  vec disc[DISC];    /* directions of equal weight */
} lamp;

static const double dome_mean = 0.32, dome_slope = 0.22;

/* What a viewer at an angle sees of a dome of radiance 1, and of one of radiance `direction`, whose
 * components along the normal and along the viewer's tangent these are. */
typedef struct moments {
  double whole[3], normal[3], tangent[3];
  double core[3], width; /* the part within `core_radius`, and its rms radius */
} moments;

/* What is nearer to the mirror point than lamp directions are to each other is no matter for sums
 * over those: f exp(-r^2 / core_radius^2) is reflected like the delta, softly, the rest is summed.
 */
static const double core_radius = 0.04;

static double core_share(double r) {
  return exp(-r * r / (core_radius * core_radius));
}

typedef struct scene {
  hetab_lobe_table table;
  moments dome[ANGLES];
  float specular[ANGLES][3];
  lamp lamps[2];
} scene;

static double dot(vec a, vec b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

static vec combine(double a, vec u, double b, vec v) {
  return (vec){a * u.x + b * v.x, a * u.y + b * v.y, a * u.z + b * v.z};
}

static vec unit(vec v) {
  double length = sqrt(dot(v, v));
  return (vec){v.x / length, v.y / length, v.z / length};
}

static vec cross(vec a, vec b) {
  return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* ---- lights -------------------------------------------------------------------------------- */

/* Rings of 6, 12, ... directions about the centre, each for the same area. */
static lamp make_lamp(vec to, double irradiance, double radius_deg) {
  lamp l = {.to = unit(to), .irradiance = irradiance, .radius = radius_deg * pi / 180};
  vec u = unit(cross(l.to, (vec){0, 0, 1})), v = cross(l.to, u);
  int n = 0;
  l.disc[n++] = l.to;
  for (int ring = 1; ring <= RINGS; ring++)
    for (int i = 0; i < 6 * ring; i++) {
      /* The middle of the ring's area: ring k holds the directions 1 + 3k(k-1) .. 3k(k+1). */
      double inner = 1 + 3.0 * ring * (ring - 1), outer = 1 + 3.0 * ring * (ring + 1);
      double angle = l.radius * sqrt((inner + outer) / 2 / DISC);
      double turn = 2 * pi * (i + 0.5 * (ring % 2)) / (6 * ring);
      vec aside = combine(cos(turn), u, sin(turn), v);
      l.disc[n++] = combine(cos(angle), l.to, sin(angle), aside);
    }
  return l;
}

/* ---- the dome ------------------------------------------------------------------------------ */

/* The integral of f dq over the disc of the light's lateral direction cosines, on rays from the
 * mirror point. */
static moments integrate_dome(const hetab_lobe_table *table, double theta) {
  moments m = {0};
  for (int ray = 0; ray < DOME_RAYS; ray++) {
    double psi = pi * (ray + 0.5) / DOME_RAYS, reach = hetab_lobe_reach(theta, cos(psi));
    for (int n = 0; n < DOME_NODES; n++) {
      double t = (n + 0.5) / DOME_NODES, r = reach * hetab_lobe_place(t);
      double area = 2 * r * reach * hetab_lobe_place_slope(t) / DOME_NODES * (pi / DOME_RAYS);
      double q[2] = {-sin(theta) + r * cos(psi), r * sin(psi)};
      double normal = sqrt(fmax(1 - q[0] * q[0] - q[1] * q[1], 0));
      double core = area * core_share(r);
      float f[3];
      hetab_lobe_table_eval(table, theta, q, f);
      m.width += core * r * r * (double)f[1];
      for (int c = 0; c < 3; c++) {
        m.core[c] += core * (double)f[c];
        m.whole[c] += area * (double)f[c];
        m.normal[c] += area * normal * (double)f[c];
        m.tangent[c] += area * q[0] * (double)f[c];
      }
    }
  }
  m.width = m.core[1] > 0 ? sqrt(fmax(m.width, 0) / m.core[1]) : 0;
  return m;
}

/* ---- a pixel ------------------------------------------------------------------------------- */

/* A point of the sphere: its normal, and the frame in which the viewer has azimuth 0. */
typedef struct place {
  vec normal, tangent, aside, mirror;
  double theta, footprint; /* of a pixel, in the mirror direction, radians */
} place;

static place make_place(double x, double y, double pixel) {
  vec viewer = {0, 0, 1}, n = {x, y, sqrt(fmax(1 - x * x - y * y, 1e-6))};
  double sin_theta = hypot(x, y);
  place p = {.normal = n, .theta = acos(fmin(n.z, 1))};
  p.tangent =
      sin_theta > 1e-9 ? combine(1 / sin_theta, viewer, -n.z / sin_theta, n) : (vec){1, 0, 0};
  p.aside = cross(n, p.tangent);
  p.mirror = combine(2 * n.z, n, -1, viewer);
  p.footprint = 2 * pixel / n.z;
  return p;
}

/* f cos(theta_i) for the mean over the lamp's disc, times its irradiance. */
static void add_lamp(const scene *s, const lamp *l, const place *p, double rgb[3]) {
  for (int i = 0; i < DISC; i++) {
    double cosine = dot(l->disc[i], p->normal);
    const double q[2] = {dot(l->disc[i], p->tangent), dot(l->disc[i], p->aside)};
    double rest = 1 - core_share(hypot(q[0] + sin(p->theta), q[1]));
    float f[3];
    if (cosine <= 0)
      continue;
    hetab_lobe_table_eval(&s->table, p->theta, q, f);
    for (int c = 0; c < 3; c++)
      rgb[c] += l->irradiance / DISC * cosine * rest * (double)f[c];
  }
}

/* The lamps' radiance in the mirror direction, their edges blurred over `blur` radians. */
static double mirrored(const scene *s, const place *p, double blur) {
  double radiance = 0;
  for (int i = 0; i < 2; i++) {
    const lamp *l = &s->lamps[i];
    double angle = acos(fmin(dot(l->to, p->mirror), 1));
    double t = fmin(fmax((l->radius - angle) / blur + 0.5, 0), 1);
    radiance += t * t * (3 - 2 * t) * l->irradiance / (pi * sin(l->radius) * sin(l->radius));
  }
  return radiance;
}

static double blend(double a, double b, double w) {
  return (1 - w) * a + w * b;
}

static void shade(const scene *s, const place *p, double rgb[3]) {
  size_t i = 0;
  while (i + 2 < ANGLES && s->table.theta[i + 1] <= p->theta)
    i++;
  double span = s->table.theta[i + 1] - s->table.theta[i];
  double w = fmin(fmax((p->theta - s->table.theta[i]) / span, 0), 1);
  const moments *a = &s->dome[i], *b = &s->dome[i + 1];
  double sky = dome_mean + dome_slope * p->mirror.y, sharp = mirrored(s, p, 1.5 * p->footprint);
  double soft = mirrored(
      s, p, fmax(1.5 * p->footprint, 4 * blend(a->width, b->width, w) / fmax(p->normal.z, 0.1)));
  for (int c = 0; c < 3; c++) {
    double rho_s = blend((double)s->specular[i][c], (double)s->specular[i + 1][c], w);
    double up = blend(a->normal[c], b->normal[c], w) * p->normal.y +
                blend(a->tangent[c], b->tangent[c], w) * p->tangent.y;
    rgb[c] = dome_mean * blend(a->whole[c], b->whole[c], w) + dome_slope * up +
             rho_s * (sky + sharp) + blend(a->core[c], b->core[c], w) * soft;
  }
  for (int k = 0; k < 2; k++)
    add_lamp(s, &s->lamps[k], p, rgb);
}

/* ---- the picture --------------------------------------------------------------------------- */

/* Steps that shrink towards grazing. */
static void place_angles(double theta[ANGLES]) {
  for (int i = 0; i < ANGLES; i++)
    theta[i] = 89.5 * pi / 180 * sin(0.5 * pi * i / (ANGLES - 1));
}

static hetab_status make_scene(hetab_context *ctx, const hetab_view_source *source, scene *s) {
  double theta[ANGLES];
  place_angles(theta);
  HETAB_TRY(hetab_lobe_table_create(ctx, source, theta, ANGLES, table_size, 1, &s->table));
  for (int i = 0; i < ANGLES; i++) {
    s->dome[i] = integrate_dome(&s->table, theta[i]);
    HETAB_TRY(source->specular(ctx, source, theta[i], s->specular[i]));
  }
  s->lamps[0] = make_lamp((vec){-0.5, 0.62, 0.6}, 2.0, 12);
  s->lamps[1] = make_lamp((vec){0.82, 0.25, -0.51}, 1.0, 9);
  return HETAB_OK;
}

static void paint_pixel(const scene *s, double x, double y, double radius, float rgb[3]) {
  double r = hypot(x, y), value[3] = {0};
  double covered = fmin(fmax((1 - r) * radius + 0.5, 0), 1);
  if (r >= 1) { /* the rim's pixels show what is just inside it */
    x *= 0.9999 / r;
    y *= 0.9999 / r;
  }
  if (covered > 0) {
    place p = make_place(x, y, 1 / radius);
    shade(s, &p, value);
  }
  for (int c = 0; c < 3; c++)
    rgb[c] = (float)(covered * value[c]);
}

static hetab_status paint(hetab_context *ctx, const scene *s, size_t side, float (*rgb)[3]) {
  double half = (double)side / 2, radius = HETAB_SPHERE_RADIUS * (double)side;
  for (size_t row = 0; row < side; row++) {
    HETAB_TRY(hetab_progress(ctx, (double)row, (double)side));
    for (size_t i = 0; i < side; i++)
      paint_pixel(s, ((double)i + 0.5 - half) / radius, (half - (double)row - 0.5) / radius, radius,
                  rgb[row * side + i]);
  }
  return HETAB_OK;
}

hetab_status hetab_view_make_sphere(hetab_context *ctx, const hetab_view_source *source,
                                    size_t side, float (*rgb)[3]) {
  HETAB_FREED scene *s = hetab_alloc(ctx, 1, sizeof *s);
  hetab_status status = s ? make_scene(ctx, source, s) : HETAB_ERR_MEMORY;
  if (status == HETAB_OK)
    status = paint(ctx, s, side, rgb);
  if (s)
    hetab_lobe_table_clear(&s->table);
  return status;
}
