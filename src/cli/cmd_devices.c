/* hetab devices: what --device can choose from. */
#include <stdio.h>
#include <stdlib.h>

#include "cli.h"
#include "options.h"
#include "output.h"

static int print_json(const hetab_device_info *devices, size_t count) {
  json_t *list = json_array();
  for (size_t i = 0; i < count; i++) {
    const hetab_device_info *d = &devices[i];
    json_array_append_new(
        list,
        json_pack("{sI so so so so si si si sI}", "number", (json_int_t)i, "name",
                  cli_json_text(d->name), "platform", cli_json_text(d->platform), "driver",
                  cli_json_text(d->driver), "opencl", cli_json_text(d->opencl), "compute_units",
                  (int)d->compute_units, "float_width", (int)d->float_width, "double_width",
                  (int)d->double_width, "memory_bytes", (json_int_t)d->memory_bytes));
  }
  return cli_json_print(list);
}

static int print_table(const hetab_device_info *devices, size_t count) {
  printf("%2s  %-40s  %5s  %6s  %10s  %s\n", "", "device", "units", "double", "memory", "platform");
  for (size_t i = 0; i < count; i++) {
    const hetab_device_info *d = &devices[i];
    printf("%2zu  %-40s  %5u  %6s  %6.1f GiB  %s\n", i, d->name, d->compute_units,
           d->double_width ? "yes" : "no", (double)d->memory_bytes / (1 << 30), d->platform);
  }
  return CLI_OK;
}

static int list_devices(hetab_context *ctx, int json) {
  HETAB_FREED hetab_device_info *devices = NULL;
  size_t count;
  CLI_CALL(ctx, hetab_device_list(ctx, &devices, &count));
  return count == 0 ? cli_fail_context(ctx)
         : json     ? print_json(devices, count)
                    : print_table(devices, count);
}

static int run(const cli_command *self, int argc, char **argv) {
  int first, json = 0;
  const cli_option options[] = {
      {CLI_FLAG, "json", 0, NULL,
       "print a JSON array of objects with number, name, platform, driver, opencl, compute_units, "
       "float_width, double_width (native vector widths; 0: no double) and memory_bytes",
       &json, 0, 0},
      {0},
  };
  int status = cli_parse_options(self, options, argc, argv, &first);
  if (status >= 0)
    return status;
  if (argv[first])
    return cli_usage(self, "unexpected argument '%s'", argv[first]);
  HETAB_ENDS(hetab_context_end) hetab_context *ctx = cli_context();
  status = ctx ? list_devices(ctx, json) : CLI_FAILURE;
  return status;
}

const cli_command cli_devices = {
    .name = "devices",
    .arguments = "",
    .summary = "list the OpenCL devices that --device can choose",
    .description =
        "Lists the OpenCL devices of all platforms. --device of the other commands takes "
        "a number from this list, several (0,1), a part of a name, or all.",
    .run = run,
};
