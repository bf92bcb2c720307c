/* What stands for the marks of the templates. */
#include <math.h>
#include <string.h>

#include "core/context.h"
#include "model/model.h"
#include "model/universal.h"
#include "shader/shader_parts.h"

enum { COUNT = HETAB_SPLINE_COUNT };

/* ---- the table ----------------------------------------------------------------------------- */

/* Its coefficients as floats: A over s, then r over t of each s. */
static const float *table_values(size_t *count) {
  static float values[COUNT + 1][COUNT];
  const hetab_universal *table = hetab_universal_table();
  for (int j = 0; j < COUNT; j++)
    values[0][j] = (float)table->a[j];
  for (int i = 0; i < COUNT; i++)
    for (int j = 0; j < COUNT; j++)
      values[1 + i][j] = (float)table->r[i][j];
  *count = sizeof values / sizeof **values;
  return *values;
}

static hetab_status write_base64(const hetab_shader_input *input, FILE *out) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  size_t count;
  const unsigned char *bytes = (const unsigned char *)table_values(&count);
  count *= sizeof(float);
  for (size_t i = 0; i < count; i += 3) {
    unsigned b[3] = {0};
    for (size_t k = 0; k < 3 && i + k < count; k++)
      b[k] = bytes[i + k];
    unsigned word = b[0] << 16 | b[1] << 8 | b[2];
    for (unsigned k = 0; k < 4; k++)
      fputc(i + k > count ? '=' : digits[word >> (18 - 6 * k) & 63], out);
  }
  return HETAB_OK;
}

static hetab_status write_numbers(const hetab_shader_input *input, FILE *out) {
  size_t count;
  const float *values = table_values(&count);
  for (size_t i = 0; i < count; i++)
    fprintf(out, "%.9gf,%s", (double)values[i] == 0.0 ? 0.0 : (double)values[i],
            i % 8 == 7 ? "\n" : "");
  return HETAB_OK;
}

/* The largest relative error of h of the table as the text holds it, above a part of h(g, 0). */
static double worst_error(const hetab_universal *table, double part) {
  double worst = 0.0;
  for (double lg = -8.0; lg < 7.0; lg += 0.1037) {
    double g = pow(10.0, lg), top = hetab_ln_h(g, 0.0);
    for (double v = 0.0, ln_h = top; v < 120.0 && ln_h - top >= log(part); v = 1.17 * v + 0.003) {
      double x = v * (1.0 + g);
      ln_h = hetab_ln_h(g, x);
      if (ln_h - top >= log(part))
        worst = fmax(worst, fabs(expm1(hetab_universal_ln_h_of(table, g, x) - ln_h)));
    }
  }
  return worst;
}

static hetab_status write_error(const hetab_shader_input *input, FILE *out) {
  size_t count;
  const float *values = table_values(&count);
  hetab_universal rounded;
  for (int j = 0; j < COUNT; j++)
    rounded.a[j] = (double)values[j];
  for (int i = 0; i < COUNT; i++)
    for (int j = 0; j < COUNT; j++)
      rounded.r[i][j] = (double)values[(1 + i) * COUNT + j];
  fprintf(
      out,
      "The series is read from a table. Error of f_dd that it adds, measured for g from 1e-8 to "
      "1e7:\n%.1e where it is above 1e-6 of the lobe's peak, %.1e to 1e-9, relative.",
      worst_error(&rounded, 1e-6), worst_error(&rounded, 1e-9));
  return HETAB_OK;
}

/* ---- colour -------------------------------------------------------------------------------- */

/* Least squares over random surfaces and angles, half of them with their spectra bent at random,
 * the white held; the bands by exchange. */
static const hetab_colour_node NODES_8[] = {
    {410, {0.01818, -0.01951, 0.09812}}, {450, {0.04386, -0.04964, 0.83432}},
    {500, {-0.21444, 0.17963, 0.25034}}, {530, {-0.32311, 0.52021, -0.14131}},
    {570, {0.44803, 0.41144, -0.01098}}, {610, {0.7532, -0.01896, -0.0315}},
    {650, {0.26661, -0.02204, 0.00126}}, {700, {0.00763, -0.00115, -0.00025}}};
static const hetab_colour_node NODES_16[] = {
    {420, {0.01535, -0.00949, 0.13932}},  {430, {0.02537, -0.04044, 0.13712}},
    {450, {0.06835, 0.0054, 0.23924}},    {460, {-0.0741, -0.0558, 0.3879}},
    {470, {-0.00612, 0.04507, 0.11108}},  {500, {-0.1712, 0.15448, 0.12176}},
    {520, {-0.15035, 0.21668, -0.05371}}, {540, {-0.14867, 0.35243, 0.01498}},
    {560, {0.1233, 0.2071, -0.07198}},    {580, {0.24156, 0.14569, -0.00477}},
    {600, {0.46612, 0.021, -0.01409}},    {620, {0.2892, -0.01186, 0.00995}},
    {630, {0.1319, -0.0107, -0.02303}},   {650, {0.15562, -0.01645, 0.00933}},
    {670, {0.02102, -0.00162, -0.00345}}, {690, {0.01264, -0.00147, 0.00035}}};

const hetab_colour_node *hetab_colour_nodes(size_t count) {
  return count == 8 ? NODES_8 : count == 16 ? NODES_16 : NULL;
}

static void write_nodes_of(size_t count, FILE *out) {
  const hetab_colour_node *nodes = hetab_colour_nodes(count);
  fprintf(out, "\"%zu\": [", count);
  for (size_t i = 0; i < count; i++)
    fprintf(out, "%s[%d, %g, %g, %g]", i ? ", " : "", nodes[i].nm, nodes[i].rgb[0], nodes[i].rgb[1],
            nodes[i].rgb[2]);
  fputc(']', out);
}

static hetab_status write_nodes(const hetab_shader_input *input, FILE *out) {
  fputc('{', out);
  write_nodes_of(8, out);
  fputs(",\n ", out);
  write_nodes_of(16, out);
  fputc('}', out);
  return HETAB_OK;
}

/* ---- metals and the surface ---------------------------------------------------------------- */

static void write_text(const char *text, FILE *out) {
  fputc('"', out);
  for (; *text; text++) /* nothing that would end a string in any of the languages */
    fputc((unsigned char)*text < ' ' || strchr("\"\\<>&'`*", *text) ? '_' : *text, out);
  fputc('"', out);
}

/* Every stride-th number, scaled. */
static void write_list(const char *name, const double *first, size_t count, size_t stride,
                       double scale, FILE *out) {
  fprintf(out, "\"%s\": [", name);
  for (size_t i = 0; i < count; i++)
    fprintf(out, "%s%.9g", i ? ", " : "", scale * first[i * stride]);
  fputc(']', out);
}

enum { METAL_BANDS = 31 };

static hetab_status write_metal(hetab_context *ctx, size_t metal, FILE *out) {
  double n[METAL_BANDS], k[METAL_BANDS];
  hetab_index *index;
  HETAB_TRY(hetab_index_metal(ctx, hetab_metal_symbol(metal), &index));
  hetab_status status = HETAB_OK;
  for (int i = 0; i < METAL_BANDS && status == HETAB_OK; i++)
    status = hetab_index_at(ctx, index, 0.4 + 0.01 * i, 1, &n[i], &k[i]);
  hetab_index_free(index);
  HETAB_TRY(status);
  fprintf(out, "%s\"%s\": {\"name\": ", metal ? ",\n " : "", hetab_metal_symbol(metal));
  write_text(hetab_metal_name(metal), out);
  fputs(", ", out);
  write_list("n", n, METAL_BANDS, 1, 1.0, out);
  fputs(", ", out);
  write_list("k", k, METAL_BANDS, 1, 1.0, out);
  fputc('}', out);
  return HETAB_OK;
}

static hetab_status write_metals(const hetab_shader_input *input, FILE *out) {
  fputc('{', out);
  for (size_t i = 0; i < hetab_metal_count(); i++)
    HETAB_TRY(write_metal(input->ctx, i, out));
  fputc('}', out);
  return HETAB_OK;
}

static hetab_status write_surface(const hetab_shader_input *input, FILE *out) {
  const hetab_surface *surface = input->surface;
  if (!surface)
    return fputs("null", out), HETAB_OK;
  const hetab_band *bands = hetab_surface_bands(surface);
  const struct {
    const char *name;
    const double *first;
    double scale;
  } lists[] = {{"wavelengths_nm", &bands->lambda_um, 1e3},
               {"n", &bands->n, 1.0},
               {"k", &bands->k, 1.0},
               {"diffuse_reflectance", &bands->diffuse_brdf, M_PI}};
  fputs("{\"name\": ", out);
  write_text(hetab_surface_name(surface), out);
  fprintf(out, ", \"sigma0_um\": %.9g, \"tau_um\": %.9g", hetab_surface_sigma0_um(surface),
          hetab_surface_tau_um(surface));
  for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
    fputs(", ", out);
    write_list(lists[i].name, lists[i].first, hetab_surface_band_count(surface),
               sizeof *bands / sizeof(double), lists[i].scale, out);
  }
  fputc('}', out);
  return HETAB_OK;
}

/* ---- names --------------------------------------------------------------------------------- */

static hetab_status write_version(const hetab_shader_input *input, FILE *out) {
  fputs(hetab_version(), out);
  return HETAB_OK;
}

#define CONSTANT(name, format, value)                                                              \
  static hetab_status write_##name(const hetab_shader_input *input, FILE *out) {                   \
    fprintf(out, format, value);                                                                   \
    return HETAB_OK;                                                                               \
  }
CONSTANT(count, "%d", COUNT)
CONSTANT(cells, "%d.0", HETAB_SPLINE_CELLS)
CONSTANT(soft_g, "%.1f", HETAB_UNIVERSAL_SOFT_G)
CONSTANT(root, "%.9g", HETAB_UNIVERSAL_ROOT)
CONSTANT(soft_v, "%.1f", HETAB_UNIVERSAL_SOFT_V)
CONSTANT(most_t, "%.17g", HETAB_UNIVERSAL_MOST_T)

hetab_shader_part_fn hetab_shader_part(const char *name, size_t length) {
  static const struct {
    const char *name;
    hetab_shader_part_fn write;
  } parts[] = {
      {"VERSION", write_version},       {"ERROR", write_error},        {"TABLE", write_base64},
      {"TABLE_NUMBERS", write_numbers}, {"COUNT", write_count},        {"CELLS", write_cells},
      {"SOFT_G", write_soft_g},         {"ROOT", write_root},          {"SOFT_V", write_soft_v},
      {"MOST_T", write_most_t},         {"COLOUR_NODES", write_nodes}, {"METALS", write_metals},
      {"SURFACE", write_surface}};
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
    if (strlen(parts[i].name) == length && strncmp(parts[i].name, name, length) == 0)
      return parts[i].write;
  return NULL;
}
