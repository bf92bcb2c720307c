/* What a finished batch is: a manifest and a page. */
#include <hetab/batch.h>

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/context.h"
#include "core/html_page.h"
#include "plan/record.h"
#include "plan/renderer_scene.h"
#include "plan/scene.h"

/* ---- the page ------------------------------------------------------------------------------ */

static const char page_styles[] =
    "<style>td:nth-child(-n+3),th:nth-child(-n+3),:is(td,th):nth-child(n+7):nth-child(-n+8)"
    "{text-align:left}"
    "th{cursor:pointer;vertical-align:bottom}td img{display:block;width:56px;height:56px}</style>";
/* Sorted by a click on a column's head. */
static const char page_script[] =
    "<script>document.querySelectorAll('th').forEach((head,c)=>head.onclick=()=>{"
    "const body=document.querySelector('tbody'),rows=[...body.rows],up=head.dataset.up!=='1';"
    "head.dataset.up=up?'1':'0';const v=r=>r.cells[c].dataset.v??r.cells[c].textContent;"
    "rows.sort((a,b)=>{const x=v(a),y=v(b),n=x-y;"
    "return(isNaN(n)?x.localeCompare(y):n)*(up?1:-1)});rows.forEach(r=>body.append(r))})</script>";

/* A dash where there is none. */
static void page_number(FILE *out, double value, double scale, int digits) {
  if (value != 0.0)
    fprintf(out, "<td data-v=\"%g\">%.*f</td>", value, digits, scale * value);
  else
    fputs("<td data-v=\"0\">-</td>", out);
}

static double table_bytes(const json_t *record) {
  return hetab_record_number(json_array_get(json_object_get(record, "files"), 0), "bytes");
}

static void page_row(FILE *out, const json_t *r) {
  const char *picture = hetab_record_text(r, "thumbnail"), *name = hetab_record_text(r, "surface");
  const char *verdict = hetab_record_text(r, "verdict"), *of = hetab_record_text(r, "table_of");
  const json_t *planned = json_object_get(r, "planned");
  bool own = table_bytes(r) > 0.0,
       shares = !own && strcmp(hetab_record_text(r, "what"), "shared") == 0;
  fputs("<tr><td>", out);
  if (*picture)
    fprintf(out, "<img alt=\"\" src=\"data:image/png;base64,%s\">", picture);
  fprintf(out, "</td><td>%s</td><td class=\"b %s\">%s</td>", name,
          *verdict == 'p'                 ? "PASS"
          : strcmp(verdict, "model") == 0 ? "WARN"
                                          : "FAIL",
          verdict);
  page_number(out, own ? hetab_record_number(planned, "error_l1") : 0.0, 100.0, 2);
  page_number(out, hetab_record_number(r, "error_l1"), 100.0, 2);
  page_number(out, hetab_record_number(r, "bias"), 100.0, 2);
  fprintf(out, "<td>%s%s%s</td><td>%s</td>", hetab_record_text(r, "what"), shares ? " with " : "",
          shares ? of : "", hetab_record_text(planned, "delta"));
  page_number(out, own ? hetab_record_number(planned, "bytes") : 0.0, 1e-6, 3);
  page_number(out, table_bytes(r), 1e-6, 3);
  page_number(out, own ? hetab_record_number(planned, "seconds") : 0.0, 1.0, 2);
  page_number(out, hetab_record_number(r, "seconds"), 1.0, 2);
  page_number(out, hetab_record_number(r, "energy"), 1.0, 3);
  page_number(out, hetab_record_number(planned, "energy_left_out"), 100.0, 3);
  fputs("</tr>\n", out);
}

static hetab_status write_page(hetab_context *ctx, const hetab_scene *scene, const hetab_plan *plan,
                               const json_t *records, const char *folder) {
  hetab_folder_file page;
  char name[64];
  size_t i;
  json_t *record;
  HETAB_TRY(hetab_folder_text(ctx, &page));
  snprintf(name, sizeof name, "%zu surfaces for %s", scene->count,
           hetab_consumer_name(scene->consumer));
  char budget[96] = "";
  if (plan->table_error > plan->asked_error)
    snprintf(budget, sizeof budget,
             "; the budget of %.3g MB leaves %.3g %%, which tables are judged by",
             1e-6 * plan->memory_bytes, 100.0 * plan->table_error);
  hetab_page_begin(page.stream, name, "Batch: ", name);
  fprintf(
      page.stream,
      "%s<p>Relative L1 error asked for: %.3g %%%s; planned: %.2f MB, %.1f s of one core, in "
      "place of %.0f MB of dense HDF5 tables. hetab %s. In pairs: expected, measured. model: its "
      "own energy is above 1, at the incidence where it reflects most. A click "
      "on a column's head sorts.</p><div class=\"wide\"><table><thead><tr><th></th>"
      "<th>surface</th><th>verdict</th><th>L1 error, %%,<br>expected</th><th><br>measured</th>"
      "<th>bias, %%</th><th>what</th><th>delta</th><th>MB,<br>expected</"
      "th><th><br>made</th>"
      "<th>seconds,<br>expected</th><th><br>taken</th>"
      "<th>most<br>reflected</th><th>left out,<br>%%</th>"
      "</tr></thead><tbody>\n",
      page_styles, 100.0 * plan->asked_error, budget, 1e-6 * plan->bytes, plan->seconds,
      1e-6 * plan->dense_bytes, hetab_version());
  json_array_foreach(records, i, record) page_row(page.stream, record);
  fprintf(page.stream, "</tbody></table></div>%s\n", page_script);
  if (scene->consumer <= HETAB_MITSUBA_SPECTRAL)
    fputs(
        "<p>In Mitsuba 3, with this folder in sys.path: <code>from scene import materials</code>, "
        "or <code>import he_torrance</code>, where the folder has it, before "
        "<code>mi.load_file(\"scene.xml\")</code>.</p>\n",
        page.stream);
  hetab_page_end(page.stream);
  return hetab_folder_save(ctx, &page, folder, "index.html");
}

/* ---- the manifest -------------------------------------------------------------------------- */

static hetab_status write_manifest(hetab_context *ctx, const json_t *records, const char *folder) {
  hetab_folder_file out;
  size_t i, n;
  json_t *record, *file, *list = json_array();
  json_array_foreach(records, i, record)
      json_array_foreach(json_object_get(record, "files"), n, file) {
    json_t *line = json_pack("{sO sO sO ss sO}", "path", json_object_get(file, "path"), "bytes",
                             json_object_get(file, "bytes"), "md5", json_object_get(file, "md5"),
                             "surface", hetab_record_text(record, "surface"), "error_l1",
                             json_object_get(record, "error_l1"));
    json_array_append_new(list, line);
  }
  hetab_status status = hetab_folder_text(ctx, &out);
  if (status == HETAB_OK) {
    json_dumpf(list, out.stream, JSON_INDENT(1));
    fputc('\n', out.stream);
    status = hetab_folder_save(ctx, &out, folder, "manifest.json");
  }
  json_decref(list);
  return status;
}

hetab_status hetab_batch_finish(hetab_context *ctx, const hetab_scene *scene,
                                const hetab_plan *plan, const char *folder) {
  json_t *records = json_array();
  for (size_t i = 0; i < scene->count; i++) {
    json_t *record = hetab_record_load(ctx, scene, i, folder);
    if (!record) /* the overview of what there is so far */
      record = json_pack("{ss ss}", "surface", hetab_surface_name(scene->surfaces[i]), "verdict",
                         "missing");
    json_array_append_new(records, record);
  }
  hetab_status status = write_manifest(ctx, records, folder);
  if (status == HETAB_OK)
    status = hetab_renderer_scene(ctx, scene, plan, records, folder);
  if (status == HETAB_OK)
    status = write_page(ctx, scene, plan, records, folder);
  json_decref(records);
  return status;
}
