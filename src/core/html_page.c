#include "core/html_page.h"

#include <math.h>

/* Light and dark, wide and narrow. */
static const char style[] =
    ":root{--bg:#fff;--fg:#1b1f24;--dim:#5c6670;--rule:#dfe3e8;--card:#f7f8fa;--c0:#2466c4;"
    "--c1:#c2410c;--c2:#15803d;--c3:#9333ea;--pass:#15803d;--warn:#a16207;--fail:#c81e1e;"
    "--law:#1b1f24;--void:#eceff3;color-scheme:light dark}\n"
    "@media(prefers-color-scheme:dark){:root{--bg:#14171b;--fg:#e6e9ed;--dim:#9aa4af;"
    "--rule:#2e343c;--card:#1b1f25;--c0:#74a9ff;--c1:#fb923c;--c2:#4ade80;--c3:#c99bff;"
    "--pass:#4ade80;--warn:#facc15;--fail:#ff7a7a;--law:#e6e9ed;--void:#23282f}}\n"
    "*{box-sizing:border-box}body{margin:0 auto;max-width:1320px;padding:24px 20px 48px;"
    "background:var(--bg);color:var(--fg);font:15px/1.5 system-ui,sans-serif}\n"
    "h1{font-size:22px;margin:0 0 4px}h2{font-size:19px;margin:36px 0 8px;overflow-wrap:anywhere}"
    "h3{font-size:15px;margin:24px 0 8px}p{margin:4px 0;color:var(--dim)}\n"
    ".b{font-weight:650;font-size:13px}.PASS{color:var(--pass)}.WARN{color:var(--warn)}"
    ".FAIL{color:var(--fail)}\n"
    ".checks{display:grid;grid-template-columns:auto auto auto 1fr;gap:0 14px;"
    "border-top:1px solid var(--rule)}\n"
    ".checks>div{display:grid;grid-template-columns:subgrid;grid-column:1/-1;padding:6px 0;"
    "border-bottom:1px solid var(--rule);align-items:baseline}\n"
    ".n{font-variant-numeric:tabular-nums;text-align:right}.d{color:var(--dim);"
    "overflow-wrap:anywhere}\n"
    ".plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,520px),1fr));"
    "gap:16px}.maps{display:grid;grid-template-columns:repeat(auto-fill,minmax(240px,1fr));"
    "gap:16px}\n"
    "figure{margin:0;padding:12px;background:var(--card);border:1px solid var(--rule);"
    "border-radius:8px}figcaption{font-size:13.5px;font-weight:600;margin-bottom:6px}\n"
    "svg{display:block;width:100%;height:auto}svg svg{width:auto}svg text{fill:var(--dim);"
    "font-size:12px}.grid{stroke:var(--rule);fill:none}.line{fill:none;stroke-width:1.6;"
    "stroke-linejoin:round}.band{stroke:none;opacity:.25}.ring{fill:none;stroke:var(--rule);"
    "stroke-width:.7;opacity:.7}\n"
    ".key{display:flex;flex-wrap:wrap;gap:4px 14px;margin:8px 0 0;font-size:13px;"
    "color:var(--dim)}.key i{display:inline-block;width:18px;height:0;"
    "border-top:3px solid;vertical-align:middle;margin-right:5px}\n"
    ".scale{display:flex;align-items:center;gap:8px;font-size:13px;color:var(--dim);margin:8px 0}"
    ".scale svg{width:180px;height:12px;border-radius:3px}\n"
    /* a shadow where there is more to the side */
    ".wide{overflow-x:auto;background:linear-gradient(90deg,var(--bg) 50%,transparent) 0/36px 100%,"
    "linear-gradient(-90deg,var(--bg) 50%,transparent) 100%/36px 100%,"
    "linear-gradient(90deg,var(--dim),transparent) 0/6px 100%,"
    "linear-gradient(-90deg,var(--dim),transparent) 100%/6px 100%;background-repeat:no-repeat;"
    "background-attachment:local,local,scroll,scroll}table{border-collapse:collapse;font-variant-"
    "numeric:tabular-nums;"
    "font-size:13.5px}td,th{padding:3px 12px 3px 0;text-align:right;"
    "border-bottom:1px solid var(--rule);white-space:nowrap}th{color:var(--dim);"
    "font-weight:500}td:first-child,th:first-child{text-align:left}\n"
    "@media(max-width:640px){body{padding:16px 12px 32px}.checks{grid-template-columns:auto 1fr "
    "auto}.d{grid-column:1/-1}figure{padding:8px}.maps{grid-template-columns:1fr 1fr;gap:8px}}\n";

/* From dark to bright, over a purple-to-yellow arc that grey-scale prints keep in order. */
static void write_map_colours(FILE *out) {
  static const double stops[][3] = {{48, 18, 92},   {60, 66, 150},  {38, 116, 158},
                                    {30, 158, 137}, {103, 198, 88}, {253, 231, 37}};
  enum { STOPS = sizeof stops / sizeof *stops };
  fputs(".m0{fill:var(--void)}", out);
  for (int level = 1; level < HETAB_PAGE_LEVELS; level++) {
    double at = (level - 1.0) / (HETAB_PAGE_LEVELS - 2) * (STOPS - 1);
    int low = (int)fmin(at, STOPS - 2);
    fprintf(out, ".m%d{fill:rgb(", level);
    for (int c = 0; c < 3; c++)
      fprintf(out, "%.0f%s", stops[low][c] + (at - low) * (stops[low + 1][c] - stops[low][c]),
              c < 2 ? " " : ")}");
  }
}

void hetab_page_text(FILE *out, const char *text) {
  for (; *text; text++) {
    const char *escaped = *text == '<'   ? "&lt;"
                          : *text == '>' ? "&gt;"
                          : *text == '&' ? "&amp;"
                          : *text == '"' ? "&quot;"
                                         : NULL;
    if (escaped)
      fputs(escaped, out);
    else
      putc(*text, out);
  }
}

void hetab_page_begin(FILE *out, const char *title, const char *heading, const char *name) {
  fputs("<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
        "content=\"width=device-width,initial-scale=1\"><title>",
        out);
  hetab_page_text(out, title);
  fputs("</title>\n<style>\n", out);
  fputs(style, out);
  write_map_colours(out);
  fputs("</style></head><body><h1>", out);
  hetab_page_text(out, heading);
  hetab_page_text(out, name);
  fputs("</h1>", out);
}

void hetab_page_end(FILE *out) {
  fputs("</body></html>\n", out);
}
