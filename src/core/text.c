#include "core/text.h"

#include <ctype.h>
#include <errno.h>
#include <iconv.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "core/input_file.h"

enum { MAX_BYTES = 16 << 20, MIB = 1 << 20, MAX_WORD = 63 };

const char *const hetab_yaml_extensions[] = {".yml", ".yaml", NULL};

static hetab_status fail_large(hetab_context *ctx, const char *path, size_t most) {
  return hetab_fail(ctx, HETAB_ERR_PARSE, "%s: larger than %zu MiB: name a YAML or CSV text file",
                    path, most / MIB);
}

/* Before its memory is asked for; what has no size (a pipe) is met when it has been read. */
static bool is_larger(FILE *file, size_t most) {
  struct stat about;
  return fstat(fileno(file), &about) == 0 && about.st_size > (off_t)most;
}

/* Reads to the end of the file; one byte is always left for the terminator. */
static hetab_status read_all(hetab_context *ctx, const char *path, FILE *file, size_t most,
                             char **text, size_t *length) {
  size_t capacity = 64 << 10, used = 0;
  char *bytes = NULL;
  do {
    capacity *= 2;
    char *larger = realloc(bytes, capacity);
    if (!larger) {
      free(bytes);
      return hetab_fail(ctx, HETAB_ERR_MEMORY, "%s: out of memory for %zu bytes", path, capacity);
    }
    bytes = larger;
    used += fread(bytes + used, 1, capacity - used - 1, file);
  } while (used == capacity - 1 && used <= most);
  int error = ferror(file) ? errno : 0;
  if (error || used > most) {
    free(bytes);
    return error ? hetab_fail(ctx, HETAB_ERR_IO, "%s: cannot read: %s: name a readable text file",
                              path, strerror(error))
                 : fail_large(ctx, path, most);
  }
  bytes[used] = '\0';
  *text = bytes;
  *length = used;
  return HETAB_OK;
}

/* ---- encodings ----------------------------------------------------------------------------- */

static void strip_byte_order_mark(char *text, size_t *length) {
  if (strncmp(text, "\xEF\xBB\xBF", 3) != 0)
    return;
  *length -= 3;
  memmove(text, text + 3, *length + 1);
}

static bool is_utf8(const char *text) {
  for (const unsigned char *c = (const unsigned char *)text; *c;) {
    int more = *c < 0x80 ? 0 : *c >= 0xC2 && *c < 0xE0 ? 1 : *c >= 0xE0 && *c < 0xF0 ? 2 : 3;
    if (*c >= 0xF5 || (*c >= 0x80 && *c < 0xC2))
      return false;
    for (c++; more > 0; more--, c++)
      if ((*c & 0xC0) != 0x80)
        return false;
  }
  return true;
}

/* Half a character at the end is left out. */
static hetab_status convert(hetab_context *ctx, const char *path, const char *from, char **text,
                            size_t *length) {
  size_t room = 2 * *length, in = *length, out = room; /* both grow by at most that */
  iconv_t converter = iconv_open("UTF-8", from);
  char *bytes = malloc(room + 1), *source = *text, *target = bytes;
  bool good = bytes && converter != (iconv_t)-1 &&
              (iconv(converter, &source, &in, &target, &out) != (size_t)-1 || errno == EINVAL);
  if (converter != (iconv_t)-1)
    iconv_close(converter);
  free(*text);
  *text = NULL;
  if (!good) {
    free(bytes);
    return hetab_fail(ctx, HETAB_ERR_PARSE, "%s: cannot be converted from %s: save it in UTF-8",
                      path, from);
  }
  *text = bytes;
  *length = room - out;
  bytes[*length] = '\0';
  return HETAB_OK;
}

/* ---- files --------------------------------------------------------------------------------- */

hetab_status hetab_bytes_read(hetab_context *ctx, const char *path, size_t most, char **text,
                              size_t *length) {
  FILE *file;
  HETAB_TRY(hetab_input_stream(ctx, path, HETAB_INPUT_TEXT, &file));
  hetab_status status = is_larger(file, most) ? fail_large(ctx, path, most)
                                              : read_all(ctx, path, file, most, text, length);
  fclose(file);
  return status;
}

static hetab_status check_text(hetab_context *ctx, const char *path, char **text, size_t *length) {
  const char *nul = memchr(*text, '\0', *length);
  if (nul) {
    size_t line = hetab_text_line(*text, (size_t)(nul - *text));
    free(*text);
    *text = NULL;
    return hetab_fail(ctx, HETAB_ERR_PARSE, "%s:%zu: not text: give a YAML or CSV file in UTF-8",
                      path, line);
  }
  strip_byte_order_mark(*text, length);
  return HETAB_OK;
}

hetab_status hetab_text_read(hetab_context *ctx, const char *path, char **text, size_t *length) {
  HETAB_TRY(hetab_bytes_read(ctx, path, MAX_BYTES, text, length));
  return check_text(ctx, path, text, length);
}

hetab_status hetab_text_read_any(hetab_context *ctx, const char *path, size_t most, char **text,
                                 size_t *length) {
  HETAB_TRY(hetab_bytes_read(ctx, path, most, text, length));
  bool little = *length >= 2 && memcmp(*text, "\xFF\xFE", 2) == 0;
  bool big = *length >= 2 && memcmp(*text, "\xFE\xFF", 2) == 0;
  if (little || big)
    HETAB_TRY(convert(ctx, path, "UTF-16", text, length));
  else if (!is_utf8(*text))
    HETAB_TRY(convert(ctx, path, "ISO-8859-1", text, length));
  return check_text(ctx, path, text, length);
}

size_t hetab_text_line(const char *text, size_t offset) {
  size_t line = 1;
  for (size_t i = 0; i < offset; i++)
    line += text[i] == '\n';
  return line;
}

hetab_status hetab_locate(hetab_context *ctx, hetab_status status, const char *path, size_t line,
                          const char *what) {
  char message[sizeof ctx->message];
  memcpy(message, ctx->message, sizeof message);
  return hetab_fail(ctx, status, "%s:%zu: %s: %s", path, line, what, message);
}

/* Levenshtein distance, letters compared without case; words longer than MAX_WORD are not near. */
static size_t edit_distance(const char *a, const char *b) {
  size_t length = strlen(b);
  if (strlen(a) > MAX_WORD || length > MAX_WORD)
    return MAX_WORD;
  size_t row[MAX_WORD + 1];
  for (size_t j = 0; j <= length; j++)
    row[j] = j;
  for (size_t i = 0; a[i]; i++) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < length; j++) {
      size_t change = diagonal + (tolower((unsigned char)a[i]) != tolower((unsigned char)b[j]));
      size_t gap = (row[j] < row[j + 1] ? row[j] : row[j + 1]) + 1;
      diagonal = row[j + 1];
      row[j + 1] = change < gap ? change : gap;
    }
  }
  return row[length];
}

const char *hetab_nearest_word(const char *text, const char *const *words) {
  const char *nearest = NULL;
  size_t best = strlen(text) / 2 + 1; /* more edits than this are no misspelling */
  for (; *words; words++) {
    if (*text && strncasecmp(text, *words, strlen(text)) == 0)
      return *words; /* "sigma" for sigma0_um */
    size_t distance = edit_distance(text, *words);
    if (distance < best) {
      best = distance;
      nearest = *words;
    }
  }
  return nearest;
}

void hetab_append_word(char *list, size_t size, const char *word) {
  size_t used = strlen(list);
  snprintf(list + used, size - used, "%s%s", used ? ", " : "", word);
}

bool hetab_has_extension(const char *path, const char *const *extensions) {
  size_t length = strlen(path);
  for (; *extensions; extensions++) {
    size_t tail = strlen(*extensions);
    if (length >= tail && strcasecmp(path + length - tail, *extensions) == 0)
      return true;
  }
  return false;
}

bool hetab_next_word(const char **cursor, char *word, size_t size) {
  const char *blanks = " \t\r\n";
  const char *start = *cursor + strspn(*cursor, blanks);
  size_t length = strcspn(start, blanks);
  size_t kept = length < size ? length : size - 1;
  memcpy(word, start, kept);
  word[kept] = '\0';
  *cursor = start + length;
  return length > 0;
}
