#include "plan/renderer_scene.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <hetab/shader.h>
#include <hetab/stand_in.h>

#include "core/context.h"
#include "plan/record.h"
#include "plan/scene.h"

static bool has_table(const json_t *record) {
  return *hetab_record_text(record, "table_of") &&
         json_array_size(json_object_get(record, "files")) +
             (strcmp(hetab_record_text(record, "what"), "shared") == 0);
}

/* "FIRST 400SEPARATOR1.2BETWEEN410..." of n, or of k. */
static void write_spectrum(FILE *out, const hetab_surface *surface, bool is_k, const char *within,
                           const char *between) {
  const hetab_band *bands = hetab_surface_bands(surface);
  for (size_t b = 0; b < hetab_surface_band_count(surface); b++)
    fprintf(out, "%s%g%s%.6g", b ? between : "", 1e3 * bands[b].lambda_um, within,
            is_k ? bands[b].k : bands[b].n);
}

/* ---- Mitsuba ------------------------------------------------------------------------------- */

static void mitsuba_conductor(FILE *out, const hetab_surface *surface, double alpha) {
  fprintf(out, "  <bsdf type=\"%s\" id=\"%s\">", alpha > 0.0 ? "roughconductor" : "conductor",
          hetab_surface_name(surface));
  if (alpha > 0.0)
    fprintf(out,
            "<string name=\"distribution\" value=\"beckmann\"/><float name=\"alpha\" "
            "value=\"%.6g\"/>",
            alpha);
  fputs("<spectrum name=\"eta\" value=\"", out);
  write_spectrum(out, surface, false, ":", ", ");
  fputs("\"/><spectrum name=\"k\" value=\"", out);
  write_spectrum(out, surface, true, ":", ", ");
  fputs("\"/></bsdf>\n", out);
}

/* he_torrance, which adds the delta to a table. */
static bool needs_material(const hetab_plan *plan) {
  for (size_t i = 0; i < plan->count; i++)
    if (plan->items[i].delta == HETAB_DELTA_MATERIAL && plan->items[i].kind <= HETAB_PLAN_SHARED)
      return true;
  return false;
}

static hetab_status mitsuba_scene(hetab_context *ctx, const hetab_scene *scene,
                                  const hetab_plan *plan, const json_t *records,
                                  const char *folder) {
  hetab_folder_file file;
  HETAB_TRY(hetab_folder_text(ctx, &file));
  fputs("<scene version=\"3.0.0\">\n", file.stream);
  if (needs_material(plan))
    fputs("  <!-- Before mi.load_file: import he_torrance, which is in this folder. -->\n",
          file.stream);
  for (size_t i = 0; i < scene->count; i++) {
    const json_t *record = json_array_get(records, i);
    const hetab_surface *surface = scene->surfaces[i];
    if (has_table(record))
      fprintf(file.stream,
              "  <bsdf type=\"%s\" id=\"%s\"><string name=\"filename\" value=\"%s.bsdf\"/>"
              "</bsdf>\n",
              plan->items[i].delta == HETAB_DELTA_MATERIAL ? "he_torrance" : "measured",
              hetab_surface_name(surface), hetab_record_text(record, "table_of"));
    else if (plan->items[i].kind >= HETAB_PLAN_MIRROR)
      mitsuba_conductor(file.stream, surface,
                        plan->items[i].kind == HETAB_PLAN_PLAIN ? hetab_stand_in_alpha(surface)
                                                                : 0.0);
  }
  fputs("</scene>\n", file.stream);
  return hetab_folder_save(ctx, &file, folder, "scene.xml");
}

static const char mitsuba_python[] =
    "\"\"\"The materials of scene.xml as dictionaries for Mitsuba 3:\n"
    "\n"
    "    import mitsuba as mi; mi.set_variant(\"llvm_ad_rgb\")\n"
    "    from scene import materials\n"
    "    mi.load_dict({\"type\": \"sphere\", \"bsdf\": materials[\"NAME\"]})\n"
    "\"\"\"\n"
    "import os\n"
    "import sys\n"
    "import xml.etree.ElementTree\n"
    "\n"
    "here = os.path.dirname(os.path.abspath(__file__))\n"
    "if os.path.exists(os.path.join(here, \"he_torrance.py\")):  # the delta is in this material\n"
    "    sys.path.insert(0, here)\n"
    "    import he_torrance\n"
    "\n"
    "\n"
    "def value(node):\n"
    "    text = node.get(\"value\")\n"
    "    if node.tag == \"spectrum\":\n"
    "        pairs = [tuple(map(float, pair.split(\":\"))) for pair in text.split(\",\")]\n"
    "        return {\"type\": \"spectrum\", \"value\": pairs}\n"
    "    if node.get(\"name\") == \"filename\":\n"
    "        return os.path.join(here, text)\n"
    "    return float(text) if node.tag == \"float\" else text\n"
    "\n"
    "\n"
    "materials = {\n"
    "    node.get(\"id\"): {\"type\": node.get(\"type\"), **{n.get(\"name\"): value(n) for n in "
    "node}}\n"
    "    for node in xml.etree.ElementTree.parse(os.path.join(here, \"scene.xml\")).getroot()}\n";

static hetab_status save_text(hetab_context *ctx, const char *folder, const char *name,
                              const char *text) {
  hetab_folder_file file;
  HETAB_TRY(hetab_folder_text(ctx, &file));
  fputs(text, file.stream);
  return hetab_folder_save(ctx, &file, folder, name);
}

static hetab_status save_material(hetab_context *ctx, const hetab_plan *plan, const char *folder) {
  HETAB_FREED char *text = NULL;
  if (!needs_material(plan))
    return HETAB_OK;
  HETAB_TRY(hetab_shader_text(ctx, NULL, HETAB_SHADER_MITSUBA, &text));
  return save_text(ctx, folder, "he_torrance.py", text);
}

/* ---- pbrt ---------------------------------------------------------------------------------- */

static hetab_status pbrt_scene(hetab_context *ctx, const hetab_scene *scene, const hetab_plan *plan,
                               const json_t *records, const char *folder) {
  hetab_folder_file file;
  HETAB_TRY(hetab_folder_text(ctx, &file));
  for (size_t i = 0; i < scene->count; i++) {
    const json_t *record = json_array_get(records, i);
    const hetab_surface *surface = scene->surfaces[i];
    const char *name = hetab_surface_name(surface);
    if (has_table(record)) {
      fprintf(file.stream,
              "MakeNamedMaterial \"%s\" \"string type\" \"measured\" \"string filename\" "
              "\"%s.bsdf\"\n",
              name, hetab_record_text(record, "table_of"));
      continue;
    }
    if (plan->items[i].kind != HETAB_PLAN_MIRROR)
      continue;
    fprintf(file.stream,
            "MakeNamedMaterial \"%s\" \"string type\" \"conductor\" \"float roughness\" 0 "
            "\"spectrum eta\" [",
            name);
    write_spectrum(file.stream, surface, false, " ", " ");
    fputs("] \"spectrum k\" [", file.stream);
    write_spectrum(file.stream, surface, true, " ", " ");
    fputs("]\n", file.stream);
  }
  return hetab_folder_save(ctx, &file, folder, "scene.pbrt");
}

hetab_status hetab_renderer_scene(hetab_context *ctx, const hetab_scene *scene,
                                  const hetab_plan *plan, const json_t *records,
                                  const char *folder) {
  if (scene->consumer == HETAB_PBRT)
    return pbrt_scene(ctx, scene, plan, records, folder);
  if (scene->consumer > HETAB_PBRT)
    return HETAB_OK;
  HETAB_TRY(mitsuba_scene(ctx, scene, plan, records, folder));
  HETAB_TRY(save_material(ctx, plan, folder));
  return save_text(ctx, folder, "scene.py", mitsuba_python);
}
