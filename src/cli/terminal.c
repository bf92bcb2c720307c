#include "terminal.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "core/printable.h"

/* How much was written, as stdio wants it: less is an error. */
static ssize_t write_printable(void *cookie, const char *text, size_t size) {
  static hetab_printable state;
  char copy[BUFSIZ];
  size_t done = 0;
  while (done < size) {
    size_t part = size - done < sizeof copy ? size - done : sizeof copy;
    memcpy(copy, text + done, part);
    hetab_make_printable(&state, copy, part, "\n\t");
    for (size_t at = 0; at < part;) {
      ssize_t written = write(STDOUT_FILENO, copy + at, part - at);
      if (written < 0)
        return (ssize_t)(done + at);
      at += (size_t)written;
    }
    done += part;
  }
  return (ssize_t)done;
}

void cli_guard_terminal(void) {
  if (!isatty(STDOUT_FILENO))
    return;
  FILE *guarded = fopencookie(NULL, "w", (cookie_io_functions_t){.write = write_printable});
  if (!guarded)
    return;
  setvbuf(guarded, NULL, _IOLBF, 0);
  stdout = guarded;
}
