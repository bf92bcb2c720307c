/* hetab plan: what tables a scene needs. */
#include <stdio.h>

#include "cli.h"
#include "options.h"
#include "plan_output.h"

/* As one word of a shell. */
static void print_word(const char *text) {
  putchar('\'');
  for (; *text; text++)
    fputs(*text == '\'' ? "'\\''" : (char[]){*text, 0}, stdout);
  putchar('\'');
}

static void print_command(const char *scene, const char *folder, const char *options) {
  fputs("hetab batch ", stdout);
  print_word(scene);
  fputs(" -o ", stdout);
  print_word(folder ? folder : "tables");
  puts(options);
}

/* Eight tasks: any number does, and any later run does what is missing. */
static int print_jobs(const char *path, const hetab_scene *scene, int scheduler) {
  if (scheduler == 0)
    fputs("#!/bin/sh\n# sbatch this file; any number of tasks, all in one shared folder\n"
          "#SBATCH --array=1-8\n#SBATCH --ntasks=1\n#SBATCH --cpus-per-task=1\nexec ",
          stdout);
  else
    fputs("parallel --quote ", stdout);
  print_command(path, hetab_scene_output(scene),
                scheduler == 0 ? "" : " --jobs 1 --shard {}/8 ::: 1 2 3 4 5 6 7 8");
  return CLI_OK;
}

static int run_plan(const char *path, int scheduler, int json) {
  HETAB_ENDS(hetab_context_end) hetab_context *ctx = cli_context();
  HETAB_ENDS(hetab_scene_end) hetab_scene *scene = NULL;
  HETAB_ENDS(hetab_plan_end) hetab_plan *plan = NULL;
  if (!ctx)
    return CLI_FAILURE;
  hetab_status status = hetab_scene_load(ctx, path, &scene);
  if (status == HETAB_OK && scheduler < 0)
    status = hetab_plan_create(ctx, scene, &plan);
  return status != HETAB_OK ? cli_fail_context(ctx)
         : scheduler >= 0   ? print_jobs(path, scene, scheduler)
         : json             ? plan_print_json(scene, plan)
                            : plan_print(scene, plan);
}

static int run(const cli_command *self, int argc, char **argv) {
  const char *scene;
  int json = 0, scheduler = -1;
  const cli_option options[] = {
      {CLI_FLAG, "json", 0, NULL, "print the plan as JSON, as described above", &json, 0, 0},
      {CLI_CHOICE, "jobs-for", 0, "slurm|parallel",
       "print the job file, or the command line, that starts the batch", &scheduler, 0, 0},
      {0}};
  CLI_TRY(cli_parse_operand(self, options, argc, argv, "SCENE", &scene));
  return run_plan(scene, scheduler, json);
}

const cli_command cli_plan = {
    .name = "plan",
    .arguments = "SCENE.yml",
    .summary = "say which tables a scene needs, before any is computed",
    .description =
        "Reads a scene and decides, from the model and small trials, what each of its surfaces "
        "needs: terms, wavelengths, the shape of its table, and whether it needs one.\n\n"
        "A scene is YAML: surfaces, a list of presets, surface files and {name: ..., sigma0_um: "
        "..., tau_um: ..., index: ...}; sweep, {index: [...], sigma0_um: [...] or {from: A, to: B, "
        "count: N, spacing: log}, or slope; tau_um, diffuse_reflectance likewise}; consumer, "
        "mitsuba-rgb, mitsuba-spectral, pbrt, merl, hdf5, exr or lookup; table_error, relative L1 "
        "(0.01); energy_error, what may be left out of all that is reflected (0.003); "
        "max_theta_i_deg and max_theta_r_deg, what occurs (90); specular_cone_deg, the width of a "
        "lobe that the delta becomes in the table (4 for pbrt and merl, else 0: never); memory_mb, "
        "10^6 bytes of all tables together (none); output, the batch's folder.\n\n"
        "A surface is what: a table; shared, the table of another within the error; mirror, the "
        "delta is all; plain, the renderer's Beckmann conductor is within the error. Errors and "
        "seconds are expected, bytes of .bsdf and .binary exact. With a budget that the error "
        "asked "
        "for does not meet, the smallest common error that does is found.\n\n"
        "--json prints an object with version, consumer, asked_error, table_error, memory_bytes, "
        "bytes, seconds, dense_bytes, dense_seconds (of 31-band dense HDF5 tables) and surfaces, "
        "an "
        "array of objects with surface, what, delta (left out, beside, material or folded), "
        "diffuse, "
        "delta_share, energy_left_out, plain (alpha, and errors of Beckmann's conductor by "
        "incidence as far as they were asked for), table_of, wavelengths, wavelength_error (a part "
        "of error_l1), theta_i, resolution, spacing_deg, bytes, seconds, error_l1; null where it "
        "is not known.",
    .run = run,
};
