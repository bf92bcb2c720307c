/* hetab surfaces: the built-in surfaces and metals, to use as they are or to start from. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "cli.h"
#include "options.h"
#include "output.h"

static int find_metal(const char *name, size_t *metal) {
  for (*metal = 0; *metal < hetab_metal_count(); ++*metal)
    if (strcmp(name, hetab_metal_symbol(*metal)) == 0 ||
        strcmp(name, hetab_metal_name(*metal)) == 0)
      return 1;
  return 0;
}

static int find_preset(const char *name, size_t *preset) {
  for (*preset = 0; *preset < hetab_preset_count(); ++*preset)
    if (strcasecmp(name, hetab_preset_name(*preset)) == 0)
      return 1;
  return 0;
}

/* ---- the list ------------------------------------------------------------------------------ */

static int list_json(void) {
  json_t *presets = json_array(), *metals = json_array();
  for (size_t i = 0; i < hetab_preset_count(); i++)
    json_array_append_new(presets,
                          json_pack("{so so}", "name", cli_json_text(hetab_preset_name(i)),
                                    "description", cli_json_text(hetab_preset_description(i))));
  for (size_t i = 0; i < hetab_metal_count(); i++)
    json_array_append_new(metals,
                          json_pack("{so so so}", "symbol", cli_json_text(hetab_metal_symbol(i)),
                                    "name", cli_json_text(hetab_metal_name(i)), "citation",
                                    cli_json_text(hetab_metal_citation(i))));
  return cli_json_print(json_pack("{so so}", "presets", presets, "metals", metals));
}

enum { NAME_COLUMN = 2, TEXT_COLUMN = 20 };

static void print_entry(const char *name, const char *text) {
  int column = printf("%*s%s", NAME_COLUMN, "", name);
  cli_print_wrapped(text, TEXT_COLUMN, column);
}

static int list_text(void) {
  puts("Presets:");
  for (size_t i = 0; i < hetab_preset_count(); i++)
    print_entry(hetab_preset_name(i), hetab_preset_description(i));
  puts("\nMetals ('index: SYMBOL' in a surface's YAML):");
  for (size_t i = 0; i < hetab_metal_count(); i++) {
    print_entry(hetab_metal_symbol(i), hetab_metal_name(i));
    print_entry("", hetab_metal_citation(i));
  }
  puts("\n'hetab surfaces NAME' prints one, to start from.");
  return CLI_OK;
}

/* ---- one preset ---------------------------------------------------------------------------- */

static json_t *bands_json(const hetab_surface *surface) {
  json_t *bands = json_array();
  for (size_t i = 0; i < hetab_surface_band_count(surface); i++) {
    const hetab_band *b = &hetab_surface_bands(surface)[i];
    json_array_append_new(bands, json_pack("{sf sf sf sf}", "wavelength_nm", 1000 * b->lambda_um,
                                           "n", b->n, "k", b->k, "diffuse_brdf", b->diffuse_brdf));
  }
  return bands;
}

static int print_preset_json(const hetab_surface *surface, size_t preset) {
  return cli_json_print(
      json_pack("{so so sf sf so so}", "name", cli_json_text(hetab_surface_name(surface)),
                "description", cli_json_text(hetab_preset_description(preset)), "sigma0_um",
                hetab_surface_sigma0_um(surface), "tau_um", hetab_surface_tau_um(surface),
                "index_source", cli_json_text(hetab_index_source(hetab_surface_index(surface))),
                "bands", bands_json(surface)));
}

static int print_yaml(hetab_context *ctx, const hetab_surface *surface) {
  HETAB_FREED char *text = NULL;
  CLI_CALL(ctx, hetab_surface_yaml(ctx, surface, &text));
  fputs(text, stdout);
  return CLI_OK;
}

static int print_preset(hetab_context *ctx, size_t preset, int json) {
  HETAB_ENDS(hetab_surface_end) hetab_surface *surface = NULL;
  CLI_CALL(ctx, hetab_surface_preset(ctx, hetab_preset_name(preset), &surface));
  return json ? print_preset_json(surface, preset) : print_yaml(ctx, surface);
}

/* ---- a microfacet material in its place ---------------------------------------------------- */

enum { STAND_IN_ANGLES = 7 };
static const double STAND_IN_UM = 0.55, RGB_UM[3] = {0.61, 0.55, 0.46};

static json_t *stand_in_json(const hetab_surface *surface, const double *theta_deg,
                             const hetab_stand_in *at, const hetab_band *rgb) {
  json_t *rows = json_array(), *n = json_array(), *k = json_array();
  for (int i = 0; i < STAND_IN_ANGLES; i++)
    json_array_append_new(rows, json_pack("{sf sf sf sf}", "theta_i_deg", theta_deg[i],
                                          "specular_share", at[i].specular_share, "error",
                                          at[i].error, "energy", at[i].energy));
  for (int c = 0; c < 3; c++) {
    json_array_append_new(n, json_real(rgb[c].n));
    json_array_append_new(k, json_real(rgb[c].k));
  }
  double alpha = hetab_stand_in_alpha(surface);
  return json_pack("{so sf sf so so so so}", "name", cli_json_text(hetab_surface_name(surface)),
                   "alpha", alpha, "roughness", sqrt(alpha), "n_rgb", n, "k_rgb", k, "bands",
                   bands_json(surface), "incidences", rows);
}

static int stand_in_text(const hetab_surface *surface, const double *theta_deg,
                         const hetab_stand_in *at, const hetab_band *rgb) {
  double alpha = hetab_stand_in_alpha(surface);
  printf("alpha         %.4g (2 sigma0 / tau)\nroughness     %.4g (its square root)\n", alpha,
         sqrt(alpha));
  for (int c = 0; c < 3; c++)
    printf("%-14s%.4g + %.4gi at %g nm\n", c ? "" : "index", rgb[c].n, rgb[c].k,
           1e3 * rgb[c].lambda_um);
  puts("              (--json: at every wavelength)\n\n"
       "At 550 nm, the share of what is reflected that only a mirror gives (a delta), how far the\n"
       "stand-in is from the model's lobe, and its energy over all that the model reflects:\n"
       "theta_i   mirror    error   energy");
  for (int i = 0; i < STAND_IN_ANGLES; i++)
    printf("%5g   %6.1f %%  %5.0f %%  %6.3f\n", theta_deg[i], 100.0 * at[i].specular_share,
           100.0 * at[i].error, at[i].energy);
  return CLI_OK;
}

/* Any surface, not presets alone. */
static int print_stand_in(const char *name, int distribution, int json) {
  static const double theta_deg[STAND_IN_ANGLES] = {0, 15, 30, 45, 60, 75, 85};
  double theta_i[STAND_IN_ANGLES];
  hetab_stand_in at[STAND_IN_ANGLES];
  hetab_band rgb[3];
  HETAB_ENDS(hetab_surface_end) hetab_surface *surface = NULL;
  HETAB_ENDS(hetab_context_end) hetab_context *ctx = cli_context();
  if (!ctx)
    return CLI_FAILURE;
  for (int i = 0; i < STAND_IN_ANGLES; i++)
    theta_i[i] = theta_deg[i] / 180.0 * M_PI;
  hetab_status status = hetab_surface_open(ctx, name, &surface);
  for (int c = 0; c < 3 && status == HETAB_OK; c++)
    status = hetab_surface_at(ctx, surface, RGB_UM[c], &rgb[c]);
  if (status == HETAB_OK)
    status = hetab_stand_in_compare(ctx, surface, (hetab_microfacets)distribution, STAND_IN_UM,
                                    theta_i, STAND_IN_ANGLES, at);
  return status != HETAB_OK ? cli_fail_context(ctx)
         : json             ? cli_json_print(stand_in_json(surface, theta_deg, at, rgb))
                            : stand_in_text(surface, theta_deg, at, rgb);
}

/* ---- one metal ----------------------------------------------------------------------------- */

enum { METAL_FIRST_NM = 400, METAL_LAST_NM = 700, METAL_STEP_NM = 10 }; /* as the surfaces' */

static int print_metal_values(hetab_context *ctx, const hetab_index *index, json_t *values) {
  for (int nm = METAL_FIRST_NM; nm <= METAL_LAST_NM; nm += METAL_STEP_NM) {
    double n, k;
    CLI_CALL(ctx, hetab_index_at(ctx, index, nm / 1000.0, 0, &n, &k));
    if (values)
      json_array_append_new(values, json_pack("{si sf sf}", "wavelength_nm", nm, "n", n, "k", k));
    else
      printf("%d,%.7g,%.7g\n", nm, n, k);
  }
  return CLI_OK;
}

static int print_metal(hetab_context *ctx, size_t metal, int json) {
  hetab_index *index;
  CLI_CALL(ctx, hetab_index_metal(ctx, hetab_metal_symbol(metal), &index));
  json_t *values = json ? json_array() : NULL;
  if (!json)
    puts("wavelength_nm,n,k");
  int status = print_metal_values(ctx, index, values);
  hetab_index_free(index);
  if (!json)
    return status;
  json_t *object = json_pack("{so so so so}", "symbol", cli_json_text(hetab_metal_symbol(metal)),
                             "name", cli_json_text(hetab_metal_name(metal)), "citation",
                             cli_json_text(hetab_metal_citation(metal)), "values", values);
  if (status == CLI_OK)
    return cli_json_print(object);
  json_decref(object);
  return status;
}

/* ---- the command --------------------------------------------------------------------------- */

static int print_one(const char *name, int json) {
  size_t i;
  HETAB_ENDS(hetab_context_end) hetab_context *ctx = cli_context();
  if (!ctx)
    return CLI_FAILURE;
  return find_preset(name, &i)  ? print_preset(ctx, i, json)
         : find_metal(name, &i) ? print_metal(ctx, i, json)
                                : cli_fail("no preset or metal '%s': 'hetab surfaces' lists "
                                           "them",
                                           name);
}

static int run(const cli_command *self, int argc, char **argv) {
  const char *surface;
  int json = 0, as = -1;
  const cli_option options[] = {
      {CLI_FLAG, "json", 0, NULL,
       "print JSON: {presets: [{name, description}], metals: [{symbol, name, citation}]}, or the "
       "one asked for with its bands or values",
       &json, 0, 0},
      {CLI_CHOICE, "as", 0, "beckmann|ggx",
       "the surface as a microfacet material, for renderers without the model, and its error", &as,
       0, 0},
      {0},
  };
  CLI_TRY(cli_parse_operand(self, options, argc, argv, NULL, &surface));
  if (as >= 0)
    return surface ? print_stand_in(surface, as, json)
                   : cli_usage(self, "--as takes the name or file of a surface");
  if (surface)
    return print_one(surface, json);
  return json ? list_json() : list_text();
}

const cli_command cli_surfaces = {
    .name = "surfaces",
    .arguments = "[NAME]",
    .summary = "list the built-in surfaces and metals, or print one",
    .description =
        "Without NAME, lists the presets and the metals with their sources. With the name of a "
        "preset, prints it as YAML to start a surface file from; with that of a metal, prints its "
        "n and k as CSV, ready to be used as an index file.\n\n"
        "With --as, prints what a microfacet material needs to stand in for a surface (a preset or "
        "a "
        "file), and its error: small where the surface is rough, not where it is nearly a mirror.",
    .run = run,
};
