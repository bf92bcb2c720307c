#include "core/printable.h"

#include <string.h>

static bool is_plain(unsigned char c, const char *kept) {
  return (c >= ' ' && c < 0x7f) || (c && c < ' ' && strchr(kept, c));
}

void hetab_make_printable(hetab_printable *state, char *text, size_t size, const char *kept) {
  for (size_t i = 0; i < size; i++) {
    unsigned char c = (unsigned char)text[i];
    bool goes_on = state->rest > 0 && (c & 0xC0) == 0x80;
    bool starts = !goes_on && c >= 0xC2 && c < 0xF5;
    if (goes_on ? state->is_c1 && c < 0xA0 : !starts && !is_plain(c, kept))
      text[i] = '?';
    state->rest = goes_on ? state->rest - 1 : !starts ? 0 : c < 0xE0 ? 1 : c < 0xF0 ? 2 : 3;
    state->is_c1 = starts && c == 0xC2;
  }
}
