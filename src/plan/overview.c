/* What a finished batch is: a manifest, a page and the renderer's scene. */
#include <hetab/batch.h>

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <hetab/output_file.h>

#include "core/context.h"
#include "core/html_page.h"
#include "plan/record.h"
#include "plan/scene.h"

typedef struct text {
  FILE *stream;
  char *bytes;
  size_t size;
} text;

static hetab_status begin(hetab_context *ctx, text *t) {
  *t = (text){0};
  t->stream = open_memstream(&t->bytes, &t->size);
  return t->stream ? HETAB_OK : hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
}

static hetab_status save(hetab_context *ctx, text *t, const char *folder, const char *name) {
  char *path = hetab_batch_path(ctx, folder, name, "");
  int failed = fclose(t->stream);
  hetab_status status = path && !failed ? hetab_text_save(ctx, path, t->bytes, t->size, 1)
                                        : hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
  free(path);
  free(t->bytes);
  return status;
}

static const char *string_of(const json_t *record, const char *key) {
  const char *found = json_string_value(json_object_get(record, key));
  return found ? found : "";
}

static double number_of(const json_t *record, const char *key) {
  return json_number_value(json_object_get(record, key));
}

/* ---- the page ------------------------------------------------------------------------------ */

static const char page_styles[] =
    "<style>td:nth-child(-n+3),th:nth-child(-n+3){text-align:left}th{cursor:pointer}"
    "td img{display:block;width:56px;height:56px}.bad{color:#b00020;font-weight:bold}</style>";
/* Sorted by a click on a column's head. */
static const char page_script[] =
    "<script>document.querySelectorAll('th').forEach((head,c)=>head.onclick=()=>{"
    "const body=document.querySelector('tbody'),rows=[...body.rows],up=head.dataset.up!=='1';"
    "head.dataset.up=up?'1':'0';const v=r=>r.cells[c].dataset.v??r.cells[c].textContent;"
    "rows.sort((a,b)=>{const x=v(a),y=v(b),n=x-y;"
    "return(isNaN(n)?x.localeCompare(y):n)*(up?1:-1)});rows.forEach(r=>body.append(r))})</script>";

static void page_row(FILE *out, const json_t *r) {
  const char *picture = string_of(r, "thumbnail");
  const json_t *planned = json_object_get(r, "planned");
  double error = number_of(r, "error_l1"), expected = number_of(planned, "error_l1");
  bool fits = json_is_true(json_object_get(r, "fits"));
  fputs("<tr><td>", out);
  if (*picture)
    fprintf(out, "<img alt=\"\" src=\"data:image/png;base64,%s\">", picture);
  fprintf(out, "</td><td>%s</td><td>%s</td>", string_of(r, "surface"), string_of(r, "what"));
  fprintf(out, "<td data-v=\"%g\">%.3f</td>", number_of(r, "bytes"), 1e-6 * number_of(r, "bytes"));
  fprintf(out, "<td data-v=\"%g\">%.2f</td><td data-v=\"%g\">%.2f</td>", error, 100.0 * error,
          expected, 100.0 * expected);
  fprintf(out, "<td data-v=\"%g\">%+.2f</td><td data-v=\"%g\">%.2f</td>", number_of(r, "bias"),
          100.0 * number_of(r, "bias"), number_of(r, "seconds"), number_of(r, "seconds"));
  fprintf(out, "<td>%.3f</td>", 100.0 * number_of(planned, "energy_left_out"));
  fprintf(out, "<td class=\"%s\">%s</td></tr>\n", fits ? "" : "bad", fits ? "pass" : "fail");
}

static hetab_status write_page(hetab_context *ctx, const hetab_scene *scene, const hetab_plan *plan,
                               const json_t *records, const char *folder) {
  text page;
  char name[64];
  size_t i;
  json_t *record;
  HETAB_TRY(begin(ctx, &page));
  snprintf(name, sizeof name, "%zu surfaces for %s", scene->count,
           hetab_consumer_name(scene->consumer));
  hetab_page_begin(page.stream, name, "Batch: ", name);
  fprintf(
      page.stream,
      "%s<p>Relative L1 error asked for: %.3g %%; planned: %.2f MB, %.1f s of one core. hetab "
      "%s. Click a column's head to sort.</p><div class=\"wide\"><table><thead><tr><th></th>"
      "<th>surface</th><th>what</th><th>MB</th><th>error, %%</th><th>expected, %%</th><th>bias, "
      "%%</th><th>seconds</th><th>left out, %%</th><th>verdict</th></tr></thead><tbody>\n",
      page_styles, 100.0 * plan->table_error, 1e-6 * plan->bytes, plan->seconds, hetab_version());
  json_array_foreach(records, i, record) page_row(page.stream, record);
  fprintf(page.stream, "</tbody></table></div>%s\n", page_script);
  hetab_page_end(page.stream);
  return save(ctx, &page, folder, "index.html");
}

/* ---- the renderer's scene ------------------------------------------------------------------ */

static bool has_table(const json_t *r) {
  const char *what = string_of(r, "what");
  return strcmp(what, "table") == 0 || strcmp(what, "shared") == 0;
}

/* alpha = 2 sigma0 / tau; 0: a mirror. */
static double alpha_of(const hetab_scene *scene, size_t i, const json_t *r) {
  return strcmp(string_of(r, "what"), "plain") == 0
             ? 2.0 * hetab_surface_sigma0_um(scene->surfaces[i]) /
                   hetab_surface_tau_um(scene->surfaces[i])
             : 0.0;
}

static void mitsuba_material(FILE *out, const hetab_scene *scene, size_t i, const json_t *r) {
  const hetab_band *middle =
      &hetab_surface_bands(scene->surfaces[i])[hetab_surface_band_count(scene->surfaces[i]) / 2];
  double alpha = alpha_of(scene, i, r);
  if (has_table(r)) {
    fprintf(out,
            "  <bsdf type=\"measured\" id=\"%s\"><string name=\"filename\" value=\"%s.bsdf\"/>"
            "</bsdf>\n",
            string_of(r, "surface"), string_of(r, "table_of"));
    return;
  }
  fprintf(out, "  <bsdf type=\"%s\" id=\"%s\">", alpha > 0.0 ? "roughconductor" : "conductor",
          string_of(r, "surface"));
  if (alpha > 0.0)
    fprintf(out,
            "<string name=\"distribution\" value=\"beckmann\"/><float name=\"alpha\" "
            "value=\"%.6g\"/>",
            alpha);
  fprintf(out,
          "<spectrum name=\"eta\" value=\"%.6g\"/><spectrum name=\"k\" value=\"%.6g\"/></bsdf>\n",
          middle->n, middle->k);
}

static void pbrt_material(FILE *out, const hetab_scene *scene, size_t i, const json_t *r) {
  const hetab_band *middle =
      &hetab_surface_bands(scene->surfaces[i])[hetab_surface_band_count(scene->surfaces[i]) / 2];
  if (has_table(r))
    fprintf(out,
            "MakeNamedMaterial \"%s\" \"string type\" \"measured\" \"string filename\" "
            "\"%s.bsdf\"\n",
            string_of(r, "surface"), string_of(r, "table_of"));
  else
    fprintf(
        out,
        "MakeNamedMaterial \"%s\" \"string type\" \"conductor\" \"float roughness\" %.6g \"bool "
        "remaproughness\" false \"rgb eta\" [%.6g %.6g %.6g] \"rgb k\" [%.6g %.6g %.6g]\n",
        string_of(r, "surface"), alpha_of(scene, i, r), middle->n, middle->n, middle->n, middle->k,
        middle->k, middle->k);
}

static hetab_status write_scene(hetab_context *ctx, const hetab_scene *scene, const json_t *records,
                                const char *folder) {
  bool pbrt = scene->consumer == HETAB_PBRT;
  text out;
  size_t i;
  json_t *record;
  if (scene->consumer > HETAB_PBRT)
    return HETAB_OK;
  HETAB_TRY(begin(ctx, &out));
  if (!pbrt)
    fputs("<scene version=\"3.0.0\">\n", out.stream);
  json_array_foreach(records, i, record) {
    if (pbrt)
      pbrt_material(out.stream, scene, i, record);
    else
      mitsuba_material(out.stream, scene, i, record);
  }
  if (!pbrt)
    fputs("</scene>\n", out.stream);
  return save(ctx, &out, folder, pbrt ? "scene.pbrt" : "scene.xml");
}

/* ---- the manifest -------------------------------------------------------------------------- */

static hetab_status write_manifest(hetab_context *ctx, const json_t *records, const char *folder) {
  text out;
  size_t i, n;
  json_t *record, *file, *list = json_array();
  json_array_foreach(records, i, record)
      json_array_foreach(json_object_get(record, "files"), n, file) {
    json_t *line =
        json_pack("{sO sO sO ss sO}", "path", json_object_get(file, "path"), "bytes",
                  json_object_get(file, "bytes"), "md5", json_object_get(file, "md5"), "surface",
                  string_of(record, "surface"), "error_l1", json_object_get(record, "error_l1"));
    json_array_append_new(list, line);
  }
  hetab_status status = begin(ctx, &out);
  if (status == HETAB_OK) {
    json_dumpf(list, out.stream, JSON_INDENT(1));
    fputc('\n', out.stream);
    status = save(ctx, &out, folder, "manifest.json");
  }
  json_decref(list);
  return status;
}

hetab_status hetab_batch_finish(hetab_context *ctx, const hetab_scene *scene,
                                const hetab_plan *plan, const char *folder) {
  json_t *records = json_array();
  for (size_t i = 0; i < scene->count; i++) {
    json_t *record = hetab_record_load(ctx, scene, i, folder);
    json_array_append_new(records, record ? record : json_object());
  }
  hetab_status status = write_manifest(ctx, records, folder);
  if (status == HETAB_OK)
    status = write_scene(ctx, scene, records, folder);
  if (status == HETAB_OK)
    status = write_page(ctx, scene, plan, records, folder);
  json_decref(records);
  return status;
}
