/* hetab surfaces: the built-in surfaces and metals, to use as they are or to start from. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
    if (strcmp(name, hetab_preset_name(*preset)) == 0)
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

static int print_preset_json(const hetab_surface *surface, size_t preset) {
  json_t *bands = json_array();
  for (size_t i = 0; i < hetab_surface_band_count(surface); i++) {
    const hetab_band *b = &hetab_surface_bands(surface)[i];
    json_array_append_new(bands, json_pack("{sf sf sf sf}", "wavelength_nm", 1000 * b->lambda_um,
                                           "n", b->n, "k", b->k, "diffuse_brdf", b->diffuse_brdf));
  }
  return cli_json_print(json_pack(
      "{so so sf sf so so}", "name", cli_json_text(hetab_surface_name(surface)), "description",
      cli_json_text(hetab_preset_description(preset)), "sigma0_um",
      hetab_surface_sigma0_um(surface), "tau_um", hetab_surface_tau_um(surface), "index_source",
      cli_json_text(hetab_index_source(hetab_surface_index(surface))), "bands", bands));
}

static int print_yaml(hetab_context *ctx, const hetab_surface *surface) {
  char *text;
  if (hetab_surface_yaml(ctx, surface, &text) != HETAB_OK)
    return cli_fail_context(ctx);
  fputs(text, stdout);
  free(text);
  return CLI_OK;
}

static int print_preset(hetab_context *ctx, size_t preset, int json) {
  hetab_surface *surface;
  if (hetab_surface_preset(ctx, hetab_preset_name(preset), &surface) != HETAB_OK)
    return cli_fail_context(ctx);
  int status = json ? print_preset_json(surface, preset) : print_yaml(ctx, surface);
  hetab_surface_free(surface);
  return status;
}

/* ---- one metal ----------------------------------------------------------------------------- */

enum { METAL_FIRST_NM = 400, METAL_LAST_NM = 700, METAL_STEP_NM = 10 }; /* the data's nodes */

static int print_metal_values(hetab_context *ctx, const hetab_index *index, json_t *values) {
  for (int nm = METAL_FIRST_NM; nm <= METAL_LAST_NM; nm += METAL_STEP_NM) {
    double n, k;
    if (hetab_index_at(ctx, index, nm / 1000.0, 0, &n, &k) != HETAB_OK)
      return cli_fail_context(ctx);
    if (values)
      json_array_append_new(values, json_pack("{si sf sf}", "wavelength_nm", nm, "n", n, "k", k));
    else
      printf("%d,%.7g,%.7g\n", nm, n, k);
  }
  return CLI_OK;
}

static int print_metal(hetab_context *ctx, size_t metal, int json) {
  hetab_index *index;
  if (hetab_index_metal(ctx, hetab_metal_symbol(metal), &index) != HETAB_OK)
    return cli_fail_context(ctx);
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
  hetab_context *ctx = cli_context();
  if (!ctx)
    return CLI_FAILURE;
  int status = find_preset(name, &i)  ? print_preset(ctx, i, json)
               : find_metal(name, &i) ? print_metal(ctx, i, json)
                                      : cli_fail("no preset or metal '%s': 'hetab surfaces' lists "
                                                 "them",
                                                 name);
  hetab_context_free(ctx);
  return status;
}

static int run(const cli_command *self, int argc, char **argv) {
  int first, json = 0;
  const cli_option options[] = {
      {CLI_FLAG, "json", 0, NULL,
       "print JSON: {presets: [{name, description}], metals: [{symbol, name, citation}]}, or the "
       "one asked for with its bands or values",
       &json, 0, 0},
      {0},
  };
  int status = cli_parse_options(self, options, argc, argv, &first);
  if (status >= 0)
    return status;
  if (argc - first > 1)
    return cli_usage(self, "unexpected argument '%s'", argv[first + 1]);
  if (argc - first == 1)
    return print_one(argv[first], json);
  return json ? list_json() : list_text();
}

const cli_command cli_surfaces = {
    .name = "surfaces",
    .arguments = "[NAME]",
    .summary = "list the built-in surfaces and metals, or print one",
    .description =
        "Without NAME, lists the presets and the metals with their sources. With the name of a "
        "preset, prints it as YAML to start a surface file from; with that of a metal, prints its "
        "n and k as CSV, ready to be used as an index file.",
    .run = run,
};
