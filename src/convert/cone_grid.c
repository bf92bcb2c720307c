#include "convert/cone_grid.h"

#include <math.h>

#include "core/angle.h"
#include "core/context.h"

/* Parts of the cone: from one theta to the next, two spacings of half vectors at most; from one phi
 * to the next at 180. */
static const double THETA_PART = 0.25, MOST_THETA_PART = 1.0, PHI_PART = 1.0 / 48.0;
static const double MOST_THETA_DEG = 1.0, MOST_PHI_DEG = 2.0, PHI_GROWTH = 0.2;
enum { MOST_NODES = 512 };

static hetab_status set_theta(hetab_context *ctx, hetab_grid *grid, hetab_axis axis, double deg) {
  double theta[MOST_NODES];
  double steps = fmin(ceil(90.0 / fmin(THETA_PART * deg, MOST_THETA_DEG)), MOST_NODES - 1);
  for (size_t i = 0; i <= (size_t)steps; i++)
    theta[i] = 90.0 * (double)i / steps;
  return hetab_grid_set_values(ctx, grid, axis, theta, (size_t)steps + 1);
}

static hetab_status set_phi(hetab_context *ctx, hetab_grid *grid, double deg) {
  double phi[MOST_NODES], back = 0.0, step = 0.0;
  size_t first = MOST_NODES - 1;
  for (; first > 1 && back + step < 180.0; first--) {
    phi[first] = 180.0 - back;
    step = fmin(fmax(PHI_GROWTH * back, PHI_PART * deg), MOST_PHI_DEG);
    back += step;
  }
  phi[first] = 0.0;
  return hetab_grid_set_values(ctx, grid, HETAB_PHI, phi + first, MOST_NODES - first);
}

/* The widest spacing in degrees; of phi the last, or what is missing to 180. */
static double spacing(const hetab_grid *grid, hetab_axis axis) {
  const double *deg = hetab_grid_deg(grid, axis);
  size_t last = hetab_grid_count(grid, axis) - 1;
  double widest = axis == HETAB_PHI ? 180.0 - deg[last] : deg[0];
  for (size_t i = axis == HETAB_PHI && last > 0 ? last : 1; i <= last; i++)
    widest = fmax(widest, deg[i] - deg[i - 1]);
  return last > 0 ? widest : HUGE_VAL;
}

static hetab_status check(hetab_context *ctx, const hetab_grid *grid, hetab_axis axis, double deg,
                          const char *path) {
  double most = deg * (axis == HETAB_PHI ? PHI_PART : MOST_THETA_PART);
  double found = spacing(grid, axis);
  if (!(deg > 0.0) || found <= most * (1.0 + 1e-6))
    return HETAB_OK;
  return hetab_fail(ctx, HETAB_ERR_RANGE,
                    "'%s' holds the delta as a lobe of %.3g degrees, which %s nodes %.3g degrees "
                    "apart%s would lose: take at most %.2g, or leave that axis out",
                    path, deg, hetab_axis_name(axis), found, axis == HETAB_PHI ? " at 180" : "",
                    most);
}

hetab_status hetab_cone_grid(hetab_context *ctx, const char *const axes[HETAB_AXIS_COUNT],
                             double cone, const char *path, hetab_grid **out) {
  double deg = hetab_degrees(cone);
  HETAB_TRY(hetab_grid_create(ctx, out));
  hetab_status status = HETAB_OK;
  for (hetab_axis axis = 0; axis < HETAB_AXIS_COUNT && status == HETAB_OK; axis++) {
    if (axes[axis])
      status = hetab_grid_set_axis(ctx, *out, axis, axes[axis]);
    else if (deg > 0.0)
      status = axis == HETAB_PHI ? set_phi(ctx, *out, deg) : set_theta(ctx, *out, axis, deg);
    if (status == HETAB_OK)
      status = check(ctx, *out, axis, deg, path);
  }
  HETAB_MADE(hetab_grid, out, status);
}
