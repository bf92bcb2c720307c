/* The refractiveindex.info database's files: DATA is a list of tables (wavelength in um, n and/or
 * k) and formulas; what else the file holds (REFERENCES, CONDITIONS, PROPERTIES, SPECS) is ignored.
 */
#include <stdlib.h>
#include <string.h>
#include "surface/formulas.h"
#include "surface/index_table.h"
#include "core/text.h"
#include "surface/yaml.h"

static const char *const root_keys[] = {"DATA", NULL};
static const char *const entry_keys[] = {"type",  "data",         "wavelength_range",
                                         "range", "coefficients", NULL};

/* ---- tables ---- */

/* One line of a table: a wavelength and `columns` values, each under its rule. */
static hetab_status read_row(hetab_context *ctx, const char *line, const hetab_rule *const *rules,
                             int columns, hetab_row *row) {
  char word[HETAB_NUMBER_TEXT * 2];
  for (int i = 0; i <= columns; i++) {
    if (!hetab_next_word(&line, word, sizeof word))
      return hetab_fail(ctx, HETAB_ERR_PARSE, "%d numbers in the row: give %d", i, columns + 1);
    double *value = i == 0 ? &row->lambda_um : &row->values[i - 1];
    HETAB_TRY(
        hetab_number_read(ctx, word, i == 0 ? &hetab_rule_wavelength_data : rules[i - 1], value));
  }
  if (hetab_next_word(&line, word, sizeof word))
    return hetab_fail(ctx, HETAB_ERR_PARSE, "more than %d numbers in the row", columns + 1);
  return HETAB_OK;
}

/* The rows of a block scalar, which starts in the line below its '|'. */
static hetab_status read_rows(hetab_yaml *file, const yaml_node_t *data, char *text,
                              const hetab_rule *const *rules, int columns, hetab_row *rows,
                              size_t *count) {
  size_t line_number = data->start_mark.line + 1;
  if (data->data.scalar.style == YAML_LITERAL_SCALAR_STYLE)
    line_number++;
  *count = 0;
  for (char *line = text; line; line_number++) {
    char *end = strchr(line, '\n');
    if (end)
      *end = '\0';
    if (line[strspn(line, " \t\r")]) {
      hetab_row *row = &rows[*count];
      row->line = line_number;
      hetab_status status = read_row(file->ctx, line, rules, columns, row);
      if (status != HETAB_OK)
        return hetab_locate(file->ctx, status, file->path, line_number, "key data");
      ++*count;
    }
    line = end ? end + 1 : NULL;
  }
  if (*count == 0)
    return hetab_yaml_fail(file, data, "data", "no rows: give lines of numbers below 'data: |'");
  return hetab_rows_sort(file->ctx, file->path, rows, count);
}

static size_t count_lines(const char *text) {
  size_t lines = 1;
  for (; *text; text++)
    lines += *text == '\n';
  return lines;
}

/* Read the rows of `data` into one curve per column. */
static hetab_status read_table(hetab_yaml *file, const yaml_node_t *entry,
                               const hetab_rule *const *rules, int columns,
                               hetab_curve *const *curves) {
  yaml_node_t *data;
  const char *text;
  HETAB_TRY(hetab_yaml_require(file, entry, "data", "add 'data: |' and rows of numbers", &data));
  HETAB_TRY(hetab_yaml_text(file, data, "data", "rows of numbers below 'data: |'", &text));
  HETAB_FREED hetab_row *rows = hetab_alloc(file->ctx, count_lines(text), sizeof *rows);
  HETAB_FREED char *lines = hetab_alloc(file->ctx, strlen(text) + 1, 1);
  HETAB_NEED(rows && lines);
  size_t count = 0;
  HETAB_TRY(read_rows(file, data, strcpy(lines, text), rules, columns, rows, &count));
  for (int i = 0; i < columns; i++)
    HETAB_TRY(hetab_rows_to_curve(file->ctx, file->path, rows, count, i,
                                  rules[i] == &hetab_rule_k_data, curves[i]));
  return HETAB_OK;
}

/* ---- formulas ---- */

/* Numbers between blanks, at most `room` of them. */
static hetab_status read_numbers(hetab_yaml *file, const yaml_node_t *node, const char *key,
                                 const hetab_rule *rule, size_t room, double *values,
                                 size_t *count) {
  const char *text;
  char word[HETAB_NUMBER_TEXT * 2];
  HETAB_TRY(hetab_yaml_text(file, node, key, "numbers between blanks", &text));
  for (*count = 0; hetab_next_word(&text, word, sizeof word); ++*count) {
    if (*count == room)
      return hetab_yaml_fail(file, node, key, "more than %zu numbers: give fewer", room);
    hetab_status status = hetab_number_read(file->ctx, word, rule, &values[*count]);
    if (status != HETAB_OK)
      return hetab_yaml_locate(file, status, node, key);
  }
  return HETAB_OK;
}

/* wavelength_range, called range in the database before 2022. */
static hetab_status read_range(hetab_yaml *file, const yaml_node_t *entry, hetab_curve *curve) {
  yaml_node_t *node = hetab_yaml_get(file, entry, "range");
  if (!node)
    HETAB_TRY(hetab_yaml_require(file, entry, "wavelength_range",
                                 "add 'wavelength_range: MIN MAX' in um", &node));
  double ends[2] = {0};
  size_t count;
  HETAB_TRY(
      read_numbers(file, node, "wavelength_range", &hetab_rule_wavelength_data, 2, ends, &count));
  if (count != 2 || !(ends[0] < ends[1]))
    return hetab_yaml_fail(file, node, "wavelength_range",
                           "not a range: give two ascending wavelengths in um");
  curve->min_um = ends[0];
  curve->max_um = ends[1];
  return HETAB_OK;
}

static hetab_status read_formula(hetab_yaml *file, const yaml_node_t *entry, int formula,
                                 hetab_curve *curve) {
  yaml_node_t *node;
  double values[HETAB_FORMULA_COEFFICIENTS];
  size_t count;
  HETAB_TRY(
      hetab_yaml_require(file, entry, "coefficients", "add 'coefficients: C1 C2 ...'", &node));
  HETAB_TRY(read_numbers(file, node, "coefficients", &hetab_rule_any, HETAB_FORMULA_COEFFICIENTS,
                         values, &count));
  if (!hetab_formula_takes(formula, count))
    return hetab_yaml_fail(file, node, "coefficients", "%zu given: formula %d takes %s", count,
                           formula, hetab_formula_counts(formula));
  HETAB_TRY(read_range(file, entry, curve));
  curve->values = hetab_alloc(file->ctx, count, sizeof *values);
  HETAB_NEED(curve->values);
  memcpy(curve->values, values, count * sizeof *values);
  curve->count = count;
  curve->formula = formula;
  return HETAB_OK;
}

/* ---- the file ---- */

/* One entry of DATA. An index has one n and at most one k. */
static hetab_status read_entry(hetab_yaml *file, const yaml_node_t *entry, hetab_index *index) {
  static const hetab_rule *const nk[] = {&hetab_rule_n_data, &hetab_rule_k_data};
  static const char *const wanted =
      "tabulated nk, tabulated n, tabulated k, or formula 1 to formula 9";
  yaml_node_t *type_node;
  const char *type;
  if (entry->type != YAML_MAPPING_NODE)
    return hetab_yaml_fail(file, entry, "DATA", "not an entry: write '- type: ...'");
  HETAB_TRY(hetab_yaml_check_keys(file, entry, entry_keys, false));
  HETAB_TRY(hetab_yaml_require(file, entry, "type", wanted, &type_node));
  HETAB_TRY(hetab_yaml_text(file, type_node, "type", wanted, &type));
  bool only_k = strcmp(type, "tabulated k") == 0;
  bool both = strcmp(type, "tabulated nk") == 0;
  if ((!only_k && index->n.count) || ((only_k || both) && index->k.count))
    return hetab_yaml_fail(file, type_node, "type", "%s a second time: keep one entry",
                           only_k ? "k"
                           : both ? "n or k"
                                  : "n");
  if (both)
    return read_table(file, entry, nk, 2, (hetab_curve *[]){&index->n, &index->k});
  if (only_k)
    return read_table(file, entry, &nk[1], 1, (hetab_curve *[]){&index->k});
  if (strcmp(type, "tabulated n") == 0)
    return read_table(file, entry, nk, 1, (hetab_curve *[]){&index->n});
  if (strncmp(type, "formula ", 8) == 0 && type[8] >= '1' && type[8] <= '0' + HETAB_FORMULAS &&
      type[9] == '\0')
    return read_formula(file, entry, type[8] - '0', &index->n);
  return hetab_yaml_fail(file, type_node, "type", "'%.40s' is not known: give %s", type, wanted);
}

static hetab_status read_data(hetab_yaml *file, hetab_index *index) {
  yaml_node_t *root = hetab_yaml_root(file), *data;
  HETAB_TRY(hetab_yaml_check_keys(file, root, root_keys, false));
  HETAB_TRY(hetab_yaml_require(file, root, "DATA",
                               "give a file of the refractiveindex.info database", &data));
  if (data->type != YAML_SEQUENCE_NODE)
    return hetab_yaml_fail(file, data, "DATA", "not a list: write '- type: ...' entries");
  const yaml_node_item_t *item = data->data.sequence.items.start;
  for (; item < data->data.sequence.items.top; item++)
    HETAB_TRY(read_entry(file, yaml_document_get_node(&file->document, *item), index));
  if (!index->n.count)
    return hetab_yaml_fail(file, data, "DATA", "no n: add a tabulated n or a formula");
  double min_um, max_um;
  hetab_index_range(index, &min_um, &max_um);
  if (min_um > max_um)
    return hetab_yaml_fail(file, data, "DATA",
                           "n and k share no wavelength: give overlapping ranges");
  return HETAB_OK;
}

hetab_status hetab_index_read_yaml(hetab_context *ctx, const char *path, hetab_index *index) {
  hetab_yaml file;
  HETAB_TRY(hetab_yaml_open(ctx, path, &file));
  hetab_status status = read_data(&file, index);
  hetab_yaml_close(&file);
  return status;
}
