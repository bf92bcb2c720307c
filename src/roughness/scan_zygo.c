/* Zygo MetroPro's ASCII data files: 14 lines of a header (MetroPro Reference Guide OMP-0347, "ASCII
 * data file"), then blocks of numbers between lines "#": intensities, perhaps none, and phases. */
#include <math.h>
#include <string.h>
#include "core/number.h"
#include "core/text.h"
#include "roughness/heights.h"

static const double invalid_phase = 2147483640.0; /* and above */

/* Number `index` (from 0) of line `line` (from 1); NaN: none. */
static double number_of(const char *text, int line, int index) {
  char word[64];
  double value = (double)NAN;
  for (int i = 1; i < line && *text; i++) {
    text += strcspn(text, "\n");
    text += *text == '\n';
  }
  for (int i = 0; i <= index; i++)
    if (!hetab_next_word(&text, word, sizeof word))
      return (double)NAN;
  return hetab_number_parse(word, &value) ? value : (double)NAN;
}

/* The last block that has numbers. */
static const char *phases(const char *text) {
  const char *found = NULL;
  for (const char *mark = text; (mark = strstr(mark, "\n#"));) {
    mark += 2;
    const char *first = mark + strspn(mark, " \t\r\n");
    if (*first && *first != '#')
      found = first;
  }
  return found;
}

hetab_status hetab_scan_zygo(hetab_context *ctx, const char *path, const char *text,
                             hetab_heights **out) {
  enum { PHASE_LINE = 4, SCALE_LINE = 8, RESOLUTION_LINE = 11 };
  static const double steps[] = {4096, 32768, 131072};
  double columns = number_of(text, PHASE_LINE, 2), rows = number_of(text, PHASE_LINE, 3);
  double pixel_m = number_of(text, SCALE_LINE, 6), wave_m = number_of(text, SCALE_LINE, 2);
  double scale = number_of(text, SCALE_LINE, 1) * number_of(text, SCALE_LINE, 4);
  double resolution = number_of(text, RESOLUTION_LINE, 0);
  const char *cursor = phases(text);
  char word[64];
  *out = NULL;
  if (!(columns >= 1 && rows >= 1 && columns * rows <= (double)HETAB_MOST_HEIGHTS && cursor))
    return hetab_fail(ctx, HETAB_ERR_PARSE, "%s: no phases in it: is the file cut off?", path);
  if (!(pixel_m > 0 && wave_m > 0 && scale > 0 && resolution >= 0 && resolution <= 2))
    return hetab_fail(ctx, HETAB_ERR_PARSE,
                      "%s: its camera is not calibrated, or its header is not Zygo's: export XYZ",
                      path);
  HETAB_TRY(hetab_heights_new(ctx, path, (size_t)columns, (size_t)rows, out));
  hetab_heights *h = *out;
  h->kind = h->rows > 1 ? HETAB_HEIGHTS_MAP : HETAB_HEIGHTS_SCANS;
  h->spacing_um = h->spacing_y_um = 1e6 * pixel_m;
  for (size_t i = 0; i < h->rows * h->columns; i++) {
    double phase;
    HETAB_TRY(hetab_go_on(ctx, i + 1));
    if (!hetab_next_word(&cursor, word, sizeof word) || !hetab_number_parse(word, &phase))
      return hetab_fail(ctx, HETAB_ERR_PARSE,
                        "%s: %zu phases, where its header says %zu: is it cut "
                        "off?",
                        path, i, h->rows * h->columns);
    h->z_um[i] =
        phase < invalid_phase ? 1e6 * phase * scale * wave_m / steps[(int)resolution] : (double)NAN;
  }
  return HETAB_OK;
}
