/* Text files, and the words of error messages about them. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include "core/context.h"

/* The whole file, NUL-terminated, without a UTF-8 byte order mark; free() it. Files with NUL bytes
 * (binary, UTF-16) and files over 16 MiB are refused: no index or surface comes near that. */
hetab_status hetab_text_read(hetab_context *ctx, const char *path, char **text, size_t *length);
/* The same of up to `most` bytes of data, which may be UTF-8, UTF-16 with its byte order mark, or
 * else Latin-1; it comes as UTF-8. */
hetab_status hetab_text_read_any(hetab_context *ctx, const char *path, size_t most, char **text,
                                 size_t *length);

/* The same of bytes of any kind; one byte, 0, follows them. */
hetab_status hetab_bytes_read(hetab_context *ctx, const char *path, size_t most, char **bytes,
                              size_t *length);

/* The line, from 1, of text[offset]. */
size_t hetab_text_line(const char *text, size_t offset);

/* Put "PATH:LINE: WHAT: " before the message that ctx holds; returns status. */
hetab_status hetab_locate(hetab_context *ctx, hetab_status status, const char *path, size_t line,
                          const char *what);

/* The word of the NULL-terminated list that `text` is probably a misspelling of, or NULL. */
const char *hetab_nearest_word(const char *text, const char *const *words);

/* Append a word to a list of words "a, b, c", as far as there is room. */
void hetab_append_word(char *list, size_t size, const char *word);

/* Whether path ends in one of the NULL-terminated extensions (".yml"), in any case. */
bool hetab_has_extension(const char *path, const char *const *extensions);
extern const char *const hetab_yaml_extensions[];

/* Copies the next word (no blanks) at *cursor into word, cut to fit; false at the end of text. */
bool hetab_next_word(const char **cursor, char *word, size_t size);
