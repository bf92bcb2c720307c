/* CSV tables of wavelength, n and (optionally) k: columns in any order, found by name. The download
 * of refractiveindex.info is one for n, whose header is "wl,n", and one for k below it; wl is in
 * um.
 */
#include <stdlib.h>
#include <string.h>
#include "core/csv.h"
#include "surface/index_table.h"

enum { WAVELENGTH, INDEX_N, INDEX_K, COLUMNS, MOST_BYTES = 16 << 20 };
static const hetab_csv_wanted wanted[COLUMNS] = {
    [WAVELENGTH] = {"wavelength|lambda|wl", HETAB_LENGTH},
    [INDEX_N] = {"n", HETAB_PLAIN},
    [INDEX_K] = {"k", HETAB_PLAIN}};
static const char example[] = "wavelength_nm,n,k or wavelength_um,n,k";

typedef struct table {
  size_t at[COLUMNS]; /* of the file's columns */
  hetab_row *rows;    /* [count] */
  size_t count, room;
  bool has_n;
} table;

static hetab_status find_columns(hetab_csv *csv, table *t) {
  static const char *const names[] = {"wavelength", "n", "k"};
  for (size_t i = 0; i < csv->columns; i++) {
    hetab_csv_column *c = &csv->column[i];
    if (c->wanted == HETAB_CSV_OTHER)
      return hetab_csv_fail(csv, "column '%.40s' not known: the header is %s", c->name, example);
    if (strcmp(c->name, "wl") == 0 && csv->columns == 2)
      c->unit = c->unit > 0 ? c->unit : 1;
  }
  for (int c = 0; c < COLUMNS; c++)
    HETAB_TRY(hetab_csv_find(csv, c, "wavelength_nm or wavelength_um", &t->at[c]));
  int second = t->has_n ? INDEX_K : INDEX_N;
  for (int c = 0; c < COLUMNS; c++)
    if ((c == WAVELENGTH || c == second) && t->at[c] == HETAB_CSV_ABSENT)
      return hetab_csv_fail(csv, "column %s missing: the header is %s", names[c], example);
  return HETAB_OK;
}

/* What has no column stays 0. */
static hetab_status read_row(hetab_csv *csv, const table *t, hetab_row *row) {
  *row = (hetab_row){.line = csv->line};
  HETAB_TRY(hetab_csv_number(csv, t->at[WAVELENGTH], &hetab_rule_wavelength_data, &row->lambda_um));
  if (t->at[INDEX_N] != HETAB_CSV_ABSENT)
    HETAB_TRY(hetab_csv_number(csv, t->at[INDEX_N], &hetab_rule_n_data, &row->values[0]));
  if (t->at[INDEX_K] == HETAB_CSV_ABSENT)
    return HETAB_OK;
  return hetab_csv_number(csv, t->at[INDEX_K], &hetab_rule_k_data, &row->values[1]);
}

/* To the end, or to the header of another table. */
static hetab_status read_rows(hetab_csv *csv, table *t) {
  double unit;
  for (t->count = 0;;) {
    HETAB_TRY(hetab_csv_row(csv));
    if (!csv->count || hetab_names_quantity(csv->field[0], "wl", HETAB_LENGTH, &unit))
      break;
    HETAB_TRY(hetab_grow(csv->ctx, &t->rows, sizeof *t->rows, t->count + 1, &t->room));
    HETAB_TRY(read_row(csv, t, &t->rows[t->count++]));
  }
  if (t->count == 0)
    return hetab_csv_fail(csv, "no rows: give lines of numbers below the header");
  return hetab_rows_sort(csv->ctx, csv->path, t->rows, &t->count);
}

static hetab_status read_table(hetab_csv *csv, table *t, hetab_index *index) {
  HETAB_TRY(find_columns(csv, t));
  HETAB_TRY(read_rows(csv, t));
  if (t->at[INDEX_N] != HETAB_CSV_ABSENT) {
    if (t->has_n)
      return hetab_csv_fail(csv, "n a second time: keep one table of it");
    HETAB_TRY(hetab_rows_to_curve(csv->ctx, csv->path, t->rows, t->count, 0, false, &index->n));
  }
  t->has_n = true;
  if (t->at[INDEX_K] == HETAB_CSV_ABSENT)
    return HETAB_OK;
  if (index->k.count)
    return hetab_csv_fail(csv, "k a second time: keep one table of it");
  return hetab_rows_to_curve(csv->ctx, csv->path, t->rows, t->count, 1, true, &index->k);
}

static hetab_status read_tables(hetab_csv *csv, table *t, hetab_index *index) {
  HETAB_TRY(hetab_csv_header(csv, wanted, COLUMNS));
  if (!csv->columns)
    return hetab_csv_fail(csv, "the file is empty: give the header wavelength_nm,n,k and rows");
  if (!csv->named)
    return hetab_csv_fail(csv, "no header: the header is %s", example);
  HETAB_TRY(read_table(csv, t, index));
  while (csv->count > 0) {
    HETAB_TRY(hetab_csv_names(csv, csv->content, wanted, COLUMNS));
    HETAB_TRY(read_table(csv, t, index));
  }
  double min_um, max_um;
  hetab_index_range(index, &min_um, &max_um);
  return min_um <= max_um
             ? HETAB_OK
             : hetab_csv_fail(csv, "n and k share no wavelength: give overlapping ranges");
}

hetab_status hetab_index_read_csv(hetab_context *ctx, const char *path, hetab_index *index) {
  hetab_csv csv;
  table t = {0};
  HETAB_TRY(hetab_csv_open(ctx, path, MOST_BYTES, &csv));
  hetab_status status = read_tables(&csv, &t, index);
  free(t.rows);
  hetab_csv_clear(&csv);
  return status;
}
