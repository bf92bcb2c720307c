#include "plan_output.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli.h"
#include "core/angle.h"
#include "core/number.h"
#include "numbers.h"
#include "output.h"

static const char *const kinds[] = {"table", "shared", "mirror", "plain"};
static const char *const deltas[] = {"left out", "beside", "material", "folded"};

/* ---- text ---------------------------------------------------------------------------------- */

static const char *terms_text(const hetab_plan_item *item) {
  static const char *const texts[] = {"dd", "dd ud", "dd delta", "dd ud delta"};
  return item->kind == HETAB_PLAN_MIRROR ? "delta" : texts[2 * (item->delta != 0) + item->diffuse];
}

static void print_item(const hetab_scene *scene, const hetab_plan *plan, size_t i, int width) {
  const hetab_plan_item *item = &plan->items[i];
  char shape[32] = "-", bytes[16] = "-", error[16] = "-", seconds[16] = "-";
  if (item->kind == HETAB_PLAN_TABLE) {
    if (item->resolution)
      snprintf(shape, sizeof shape, "%zu x %zu^2 x %zu", item->theta_i_count, item->resolution,
               item->wavelengths);
    if (item->spacing_deg > 0.0 && !item->resolution &&
        hetab_scene_consumer(scene) != HETAB_CONSUMER_MERL)
      snprintf(shape, sizeof shape, "%.2g deg x %zu", item->spacing_deg, item->wavelengths);
    cli_si((double)item->bytes, bytes, sizeof bytes);
    snprintf(seconds, sizeof seconds, "%.2f", item->seconds);
    if (item->error_l1 > 0.0)
      snprintf(error, sizeof error, "%s %%", hetab_two_digits(100.0 * item->error_l1).text);
  }
  printf("%-*s %-7s %-12s %-15s %9s %8s %8s %9s %%", width,
         hetab_surface_name(hetab_scene_surface(scene, i)), kinds[item->kind], terms_text(item),
         shape, bytes, seconds, error, hetab_two_digits(100.0 * item->energy_left_out).text);
  if (item->kind == HETAB_PLAN_SHARED)
    printf("  the table of %s", hetab_surface_name(hetab_scene_surface(scene, item->shares)));
  else if (item->kind == HETAB_PLAN_MIRROR)
    printf("  no table: a smooth conductor");
  else if (item->kind == HETAB_PLAN_PLAIN)
    printf("  no table: a rough conductor, Beckmann, alpha %.4g",
           hetab_stand_in_alpha(hetab_scene_surface(scene, i)));
  putchar('\n');
}

/* How the deltas are carried, and what a renderer lacks that is not told. */
static void print_deltas(const hetab_scene *scene, const hetab_plan *plan) {
  static const char *const how[] = {
      NULL, "is beside the tables: /specular_reflectance, an .exr part, or NAME.specular.csv",
      "is added by the material he_torrance, which the batch writes beside scene.xml",
      "is folded into the tables as a lobe"};
  for (int d = HETAB_DELTA_BESIDE; d <= HETAB_DELTA_FOLDED; d++) {
    size_t count = 0;
    double share = 0.0;
    for (size_t i = 0; i < plan->count; i++)
      if ((int)plan->items[i].delta == d && plan->items[i].kind <= HETAB_PLAN_SHARED) {
        count++;
        share = fmax(share, plan->items[i].delta_share);
      }
    if (count)
      printf("the delta of %zu surfaces, up to %s %% of what they reflect at one incidence, %s\n",
             count, hetab_two_digits(100.0 * share).text, how[d]);
  }
}

/* Tables of grids that cannot be as exact as asked. */
static void print_misses(const hetab_scene *scene, const hetab_plan *plan) {
  size_t count = 0, worst = 0;
  for (size_t i = 0; i < plan->count; i++) {
    const hetab_plan_item *item = &plan->items[i];
    if (item->kind != HETAB_PLAN_TABLE || item->error_l1 <= 1.5 * plan->table_error)
      continue;
    if (!count++ || item->error_l1 > plan->items[worst].error_l1)
      worst = i;
  }
  if (count)
    printf(
        "%zu of the tables cannot be that exact, %s's least of all: .bsdf tables follow the lobe "
        "(consumer: pbrt, mitsuba-rgb), and hetab shader has the model itself\n",
        count, hetab_surface_name(hetab_scene_surface(scene, worst)));
}

static void print_sums(const hetab_scene *scene, const hetab_plan *plan) {
  size_t of_kind[4] = {0};
  double left_out = 0.0;
  for (size_t i = 0; i < plan->count; i++) {
    of_kind[plan->items[i].kind]++;
    left_out = fmax(left_out, plan->items[i].energy_left_out);
  }
  printf("%zu surfaces for %s: %zu tables, %zu shared, %zu mirrors, %zu plain; %.2f MB, %.1f s of "
         "one core\n",
         plan->count, hetab_consumer_name(hetab_scene_consumer(scene)), of_kind[0], of_kind[1],
         of_kind[2], of_kind[3], 1e-6 * plan->bytes, plan->seconds);
  if (plan->table_error > plan->asked_error)
    printf("the budget of %.3g MB leaves an error of at most %s %% for all (above: expected); %s "
           "%% was asked for\n",
           1e-6 * plan->memory_bytes, hetab_two_digits(100.0 * plan->table_error).text,
           hetab_two_digits(100.0 * plan->asked_error).text);
  print_misses(scene, plan);
  print_deltas(scene, plan);
  printf("instead of %.2f MB and %.1f s of 31-band dense HDF5 tables; left out: at most %s %% of "
         "what a surface reflects\n",
         1e-6 * plan->dense_bytes, plan->dense_seconds, hetab_two_digits(100.0 * left_out).text);
}

int plan_print(const hetab_scene *scene, const hetab_plan *plan) {
  size_t width = strlen("surface");
  for (size_t i = 0; i < plan->count; i++)
    width = (size_t)fmax((double)width,
                         (double)strlen(hetab_surface_name(hetab_scene_surface(scene, i))));
  if (plan->count)
    printf("%-*s %-7s %-12s %-15s %9s %8s %8s %11s\n", (int)width, "surface", "what", "terms",
           "shape", "bytes", "seconds", "error", "left out");
  for (size_t i = 0; i < plan->count; i++)
    print_item(scene, plan, i, (int)width);
  print_sums(scene, plan);
  return CLI_OK;
}

/* ---- JSON ---------------------------------------------------------------------------------- */

static json_t *number_or_null(double value) {
  return value > 0.0 ? json_real(value) : json_null();
}

/* Of the renderer's own rough conductor, at the incidences that were asked for. */
static json_t *plain_json(const hetab_surface *surface, const hetab_plan_item *item) {
  json_t *errors = json_array();
  for (int t = 0; t < HETAB_PLAIN_ANGLES && item->plain_errors[t] > 0.0; t++)
    json_array_append_new(errors,
                          json_pack("{sf sf}", "theta_i_deg", hetab_degrees(item->plain_theta_i[t]),
                                    "error_l1", item->plain_errors[t]));
  return json_pack("{sf so}", "alpha", hetab_stand_in_alpha(surface), "errors", errors);
}

static json_t *item_json(const hetab_scene *scene, const hetab_plan *plan, size_t i) {
  const hetab_plan_item *item = &plan->items[i];
  const char *shared = hetab_surface_name(hetab_scene_surface(scene, item->shares));
  return json_pack("{so ss ss sb sf sf so ss sI sf sI sI so sI sf so}", "surface",
                   cli_json_text(hetab_surface_name(hetab_scene_surface(scene, i))), "what",
                   kinds[item->kind], "delta", deltas[item->delta], "diffuse", item->diffuse,
                   "delta_share", item->delta_share, "energy_left_out", item->energy_left_out,
                   "plain", plain_json(hetab_scene_surface(scene, i), item), "table_of", shared,
                   "wavelengths", (json_int_t)item->wavelengths, "wavelength_error",
                   item->wavelength_error, "theta_i", (json_int_t)item->theta_i_count, "resolution",
                   (json_int_t)item->resolution, "spacing_deg", number_or_null(item->spacing_deg),
                   "bytes", (json_int_t)item->bytes, "seconds", item->seconds, "error_l1",
                   number_or_null(item->error_l1));
}

int plan_print_json(const hetab_scene *scene, const hetab_plan *plan) {
  json_t *items = CLI_JSON_LIST(plan->count, item_json(scene, plan, i));
  return cli_json_print(json_pack(
      "{ss ss sf sf so sf sf sf sf so}", "version", hetab_version(), "consumer",
      hetab_consumer_name(hetab_scene_consumer(scene)), "asked_error", plan->asked_error,
      "table_error", plan->table_error, "memory_bytes", number_or_null(plan->memory_bytes), "bytes",
      plan->bytes, "seconds", plan->seconds, "dense_bytes", plan->dense_bytes, "dense_seconds",
      plan->dense_seconds, "surfaces", items));
}
