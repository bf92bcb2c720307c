/* The one reader of delimited text: encodings, separators, decimals, headers, units, and noise. */
#include <math.h>

#include "core/csv.h"
#include "text_fixture.h"

enum { X, Z, NOTE, WANTED };
static const hetab_csv_wanted wanted[WANTED] = {[X] = {"x#|pos*|lateral", HETAB_LENGTH},
                                                [Z] = {"z|raw", HETAB_LENGTH},
                                                [NOTE] = {"theta", HETAB_ANGLE}};

static void assert_ok(const text_fixture *f, hetab_status status) {
  if (status != HETAB_OK)
    fail_msg("%s", hetab_error_message(f->ctx));
}

/* The rows of x and z in um, at most 8 of them; the line of the last. */
static size_t read_text(text_fixture *f, const char *text, size_t length, double rows[8][2],
                        size_t *line) {
  hetab_csv csv;
  size_t x, z, count = 0;
  assert_ok(f, hetab_csv_open(f->ctx, write_bytes(f, "a.txt", text, length), 1 << 20, &csv));
  assert_ok(f, hetab_csv_header(&csv, wanted, WANTED));
  if (!csv.named)
    fail_msg("no header: %s", text);
  assert_ok(f, hetab_csv_find(&csv, X, "x_um", &x));
  assert_ok(f, hetab_csv_find(&csv, Z, "z_um", &z));
  assert_true(x != HETAB_CSV_ABSENT && z != HETAB_CSV_ABSENT);
  for (;; count++) {
    assert_ok(f, hetab_csv_row(&csv));
    if (!csv.count)
      break;
    assert_true(count < 8);
    assert_ok(f, hetab_csv_value(&csv, x, &rows[count][0]));
    assert_ok(f, hetab_csv_value(&csv, z, &rows[count][1]));
    *line = csv.line;
  }
  hetab_csv_clear(&csv);
  return count;
}

/* 0 1 / 0.5 -2.25 in um, whatever the layout. */
static void assert_table(text_fixture *f, const char *text, size_t length, size_t last_line) {
  static const double expected[2][2] = {{0, 1}, {0.5, -2.25}};
  double rows[8][2];
  size_t line = 0;
  if (read_text(f, text, length, rows, &line) != 2 || line != last_line)
    fail_msg("line %zu: %s", line, text);
  for (int i = 0; i < 4; i++)
    if (fabs(rows[i / 2][i % 2] - expected[i / 2][i % 2]) > 1e-15)
      fail_msg("%.17g in: %s", rows[i / 2][i % 2], text);
}

static void test_layouts(void **state) {
  static const struct {
    const char *text;
    size_t last_line;
  } cases[] = {
      {"x_um,z_um\n0,1\n0.5,-2.25\n", 3},
      {"x_um;z_um\r\n0;1\r\n0,5;-2,25\r\n", 3},
      {"x_um\tz_um\r0\t1\r0,5\t-2,25", 3},
      {"x_um z_um\n0 1\n0,5 -2,25\n", 3},
      {"  x_um   z_um\n0\t 1\n\n0.5   -2.25  \n", 4},
      {"\"x, um\",\"z \"\"raw\"\" um\",\"z [um]\"\n0,9,1\n\"0.5\",9,\"-2.25\"\n", 3},
      {"# x_um,z_um\n#\nx_um,z_um # here\n0,1 # one\n# two\n0.5,-2.25#three\n", 6},
      {"Point #,X (mm),Z/nm\n1,0,1000\n2,5e-4,-2250\n", 3},
      {"made by hand\nx,9\nDate,2005-01-02\n\nLateral um,Raw Micrometer,\n0,1,,\n0.5,-2.25,,\n", 7},
      {"Points\n2\n5 \" wafer\nx\tz\n[nm]\t[\u00b5m]\n0\t1\n500\t-2.25\n", 7},
      {"X in \u03bcm,remark,z (microns)\n0,a;b,1\n0.5,\"c, d\",-2.25\n", 3},
      {"position1_\u00c5;y;z\u00a0(\u00b5m)\n0;x;1\n5000,0;y;-2,25\n", 3},
      {"zero,x1_m,z_cm\nno,0,1e-4\nno,5e-7,-0.000225\n", 3},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    assert_table(*state, cases[i].text, strlen(cases[i].text), cases[i].last_line);
}

static void test_encodings(void **state) {
  static const char latin[] = "x_\xB5m;z_nm;\xD6l\n0;1000;\xE4\n0,5;-2250;\xFF\n";
  assert_table(*state, latin, sizeof latin - 1, 3);
  static const char text[] = "x_um,z_um\r\n0,1\r\n0.5,-2.25\r\n";
  for (int big = 0; big < 2; big++) {
    char wide[2 * sizeof text] = {(char)(big ? 0xFE : 0xFF), (char)(big ? 0xFF : 0xFE)};
    for (size_t i = 0; i + 1 < sizeof text; i++)
      wide[2 * i + 2 + (size_t)big] = text[i];
    assert_table(*state, wide, 2 * sizeof text, 3);
  }
  static const char marked[] = "\xEF\xBB\xBFx_um,z_um\n0,1\n0.5,-2.25";
  assert_table(*state, marked, sizeof marked - 1, 3);
}

static void test_without_header(void **state) {
  static const struct {
    const char *text;
    size_t columns;
    double last;
  } cases[] = {
      {"1 2\n3 4\n", 2, 4}, {"1;2,5\n", 2, 2.5},          {"note\n7\n1 2,5\n3 4,5\n", 2, 4.5},
      {"1\n2\n", 1, 2},     {"1, 2, 3\n4, nan, 6", 3, 6}, {"a,b,c\n1,2,3\n", 3, 3}};
  text_fixture *f = *state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hetab_csv csv;
    double value = NAN;
    hetab_csv_of_text(f->ctx, "a", cases[i].text, &csv);
    assert_ok(f, hetab_csv_header(&csv, wanted, WANTED));
    assert_int_equal(csv.columns, cases[i].columns);
    assert_int_equal(csv.named, *cases[i].text == 'a'); /* names, none of them wanted */
    for (assert_ok(f, hetab_csv_row(&csv)); csv.count; assert_ok(f, hetab_csv_row(&csv)))
      assert_ok(f, hetab_csv_value(&csv, csv.columns - 1, &value));
    assert_true(value == cases[i].last);
    hetab_csv_clear(&csv);
  }
}

static void test_failures(void **state) {
  static const hetab_rule rule = {0, 10, "a length up to 10 um"};
  static const struct {
    const char *text, *words[4];
  } cases[] = {
      {"x_um,z_um\n0,1\n1\n", {"a.txt:3", "1 field where", "names 2"}},
      {"x_um,z_um\n0,1\n1,2,3\n", {"a.txt:3", "3 fields"}},
      {"x_um,z_um\n1,two\n1,2\n", {"a.txt:2", "column 'z_um'", "'two' is not a number"}},
      {"x_um,z_um\n1,20\n", {"a.txt:2", "column 'z_um'", "20 is out of range", "up to 10 um"}},
      {"x_um;z_um\n1.0;2,5\n", {"a.txt:2", "'2,5'", "'.' before the decimals"}},
      {"x_um;z_um\n1;1.234,5\n", {"a.txt:2", "'1.234,5'"}},
      {"x_um;z_um\n1;0x10\n", {"a.txt:2", "'0x10'"}},
      {"x_um,z_um\n0,1\n\"1,2\n", {"a.txt:3", "quote"}},
      {"x_um,z_um,x_nm\n0,1,1\n", {"a.txt:1", "'x_um'", "twice", "'x_nm'"}},
      {"x_furlong,z_um\n0,1\n", {"a.txt:1", "'x_furlong'", "unit not known", "x_um"}},
  };
  text_fixture *f = *state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    hetab_csv csv;
    size_t at[2];
    double value;
    hetab_status status = HETAB_OK;
    assert_ok(f, hetab_csv_open(f->ctx, write_text_file(f, "a.txt", cases[i].text), 1000, &csv));
    assert_ok(f, hetab_csv_header(&csv, wanted, WANTED));
    for (int c = X; c <= Z && status == HETAB_OK; c++)
      status = hetab_csv_find(&csv, c, "x_um", &at[c]);
    while (status == HETAB_OK && (status = hetab_csv_row(&csv)) == HETAB_OK && csv.count)
      for (int c = X; c <= Z && status == HETAB_OK; c++)
        status = hetab_csv_number(&csv, at[c], &rule, &value);
    if (status == HETAB_OK)
      fail_msg("accepted: %s", cases[i].text);
    assert_message(f, (const char *const[]){cases[i].words[0], cases[i].words[1], cases[i].words[2],
                                            cases[i].words[3], NULL});
    hetab_csv_clear(&csv);
  }
}

static void test_what_stands_above(void **state) {
  static const char text[] =
      "# Breite: 1,5 \u00b5m\n#H\u00f6he = 2 um\n\"Width\";7\n1 2 3\n4 5 6\n";
  text_fixture *f = *state;
  hetab_csv csv;
  char value[32];
  hetab_csv_of_text(f->ctx, "a", text, &csv);
  assert_ok(f, hetab_csv_header(&csv, wanted, WANTED));
  assert_int_equal(csv.columns, 3);
  assert_true(hetab_csv_above(&csv, "largeur|breite", value, sizeof value));
  assert_string_equal(value, "1,5 um");
  assert_true(hetab_csv_above(&csv, "hohe", value, sizeof value));
  assert_string_equal(value, "2 um");
  assert_true(hetab_csv_above(&csv, "width", value, sizeof value));
  assert_string_equal(value, "7");
  assert_false(hetab_csv_above(&csv, "wid|height", value, sizeof value));
  hetab_csv_clear(&csv);
}

/* ---- noise --------------------------------------------------------------------------------- */

/* Reads all there is to read; whatever it says, it says in one line and comes to an end. */
static void read_noise(text_fixture *f, const char *text, size_t length, int way, bool in_file) {
  hetab_csv csv;
  double value;
  hetab_status status = HETAB_OK;
  if (in_file)
    status = hetab_csv_open(f->ctx, write_bytes(f, "noise", text, length), 1 << 20, &csv);
  else
    hetab_csv_of_text(f->ctx, "noise", text, &csv);
  if (status == HETAB_OK)
    status = hetab_csv_header(&csv, wanted, way == 1 ? 0 : WANTED);
  csv.ragged = way == 2;
  size_t rows = 0;
  while (status == HETAB_OK && (status = hetab_csv_row(&csv)) == HETAB_OK && csv.count) {
    assert_true(++rows <= length + 1 && csv.line <= length + 1);
    for (size_t i = 0; i < csv.count; i++)
      (void)hetab_csv_parse(&csv, csv.field[i], &value);
    if (csv.columns && csv.count)
      (void)hetab_csv_value(&csv, csv.count - 1, &value);
  }
  if (status != HETAB_OK)
    assert_message(f, (const char *const[]){"noise", NULL});
  hetab_csv_clear(&csv);
}

/* Good tables with bytes changed, put in and cut off: 30,000 of them, some from files. */
static void test_noise(void **state) {
#define SEED(text)                                                                                 \
  { text, sizeof text - 1 }
  static const struct {
    const char *text;
    size_t length;
  } seeds[] = {SEED("# a\nx_um,z_um\n0,1\n0.5,\"2\"\n"), SEED("Kopf;1\nx;z\nmm;um\n0,5;1\n1,5;2\n"),
               SEED("1 2 3\n4 5 6\n"), SEED("\xFF\xFEx\0_\0u\0m\0\n\0\x31\0\n\0"),
               SEED("x_\xB5m\tz_nm\r\n1\t2\r\n")};
  static const char marks[] = "\"#,;\t \n\r\0\xFF.-1xz";
  uint64_t random = 1;
  for (int trial = 0; trial < 30000; trial++) {
    char text[256];
    size_t seed = (size_t)trial % 5, length = seeds[seed].length;
    memcpy(text, seeds[seed].text, length);
    for (int change = 0; change < 1 + trial % 7; change++) {
      random = random * 6364136223846793005u + 1442695040888963407u;
      size_t at = (random >> 33) % length;
      char byte =
          (random >> 20 & 3) ? marks[(random >> 24) % (sizeof marks - 1)] : (char)(random >> 24);
      if (random >> 22 & 1) {
        memmove(text + at + 1, text + at, length - at);
        length++;
      }
      text[at] = byte;
      if ((random >> 50) % 16 == 0 && at)
        length = at;
    }
    text[length] = '\0';
    read_noise(*state, text, length, trial % 3, trial % 50 == 0);
  }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, text_fixture_setup, text_fixture_teardown)

int main(void) {
  const struct CMUnitTest tests[] = {TEST(test_layouts),           TEST(test_encodings),
                                     TEST(test_without_header),    TEST(test_failures),
                                     TEST(test_what_stands_above), TEST(test_noise)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
