#include "surface/yaml.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/text.h"

enum { MAX_OPEN = 100, MAX_ANCHORS = 1000 };

static hetab_status fail_to_parse(const hetab_yaml *file, const yaml_parser_t *parser,
                                  const char *text) {
  if (parser->error == YAML_MEMORY_ERROR)
    return hetab_fail(file->ctx, HETAB_ERR_MEMORY, "%s: out of memory", file->path);
  /* Errors of the character decoder carry an offset in bytes instead of a line. */
  if (parser->error == YAML_READER_ERROR)
    return hetab_fail(file->ctx, HETAB_ERR_PARSE,
                      "%s:%zu: not UTF-8 text: %s: save the file as plain UTF-8", file->path,
                      hetab_text_line(text, parser->problem_offset), parser->problem);
  return hetab_fail(
      file->ctx, HETAB_ERR_PARSE,
      "%s:%zu: not valid YAML: %s: check the indentation, colons, quotes and brackets", file->path,
      parser->problem_mark.line + 1, parser->problem);
}

static hetab_status check_root(hetab_yaml *file) {
  const yaml_node_t *root = hetab_yaml_root(file);
  if (!root)
    return hetab_fail(file->ctx, HETAB_ERR_PARSE,
                      "%s:1: the file is empty: write 'key: value' lines", file->path);
  if (root->type != YAML_MAPPING_NODE)
    return hetab_fail(file->ctx, HETAB_ERR_PARSE, "%s:%zu: no keys: write 'key: value' lines",
                      file->path, root->start_mark.line + 1);
  return HETAB_OK;
}

static hetab_status check_no_second_document(hetab_yaml *file, yaml_parser_t *parser,
                                             const char *text) {
  yaml_document_t second;
  if (!yaml_parser_load(parser, &second))
    return fail_to_parse(file, parser, text);
  const yaml_node_t *root = yaml_document_get_root_node(&second);
  hetab_status status = HETAB_OK;
  if (root)
    status = hetab_fail(file->ctx, HETAB_ERR_PARSE,
                        "%s:%zu: a second YAML document: keep one document per file", file->path,
                        root->start_mark.line + 1);
  yaml_document_delete(&second);
  return status;
}

static hetab_status load_document(hetab_yaml *file, yaml_parser_t *parser, const char *text) {
  if (!yaml_parser_load(parser, &file->document))
    return fail_to_parse(file, parser, text);
  hetab_status status = check_root(file);
  if (status == HETAB_OK)
    status = check_no_second_document(file, parser, text);
  if (status != HETAB_OK)
    hetab_yaml_close(file);
  return status;
}

/* libyaml's time is quadratic in the open brackets and in the anchors: minutes for a file of junk
 * brackets. Texts in index files hold a few of them, data none. */
static hetab_status check_tame(const hetab_yaml *file, const char *text) {
  int open = 0, anchors = 0;
  for (const char *c = text; *c; c++) {
    open += (*c == '[' || *c == '{') - (open > 0 && (*c == ']' || *c == '}'));
    anchors += *c == '&';
    if (open > MAX_OPEN || anchors > MAX_ANCHORS)
      return hetab_fail(file->ctx, HETAB_ERR_PARSE,
                        "%s:%zu: too many %s: give a plain list of keys and values", file->path,
                        hetab_text_line(text, (size_t)(c - text)),
                        open > MAX_OPEN ? "open brackets" : "anchors (&)");
  }
  return HETAB_OK;
}

hetab_status hetab_yaml_open(hetab_context *ctx, const char *path, hetab_yaml *file) {
  *file = (hetab_yaml){.ctx = ctx, .path = path};
  HETAB_FREED char *text = NULL;
  size_t length;
  HETAB_TRY(hetab_text_read(ctx, path, &text, &length));
  yaml_parser_t parser;
  hetab_status status = check_tame(file, text);
  if (status == HETAB_OK && yaml_parser_initialize(&parser)) {
    yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, length);
    status = load_document(file, &parser, text);
    yaml_parser_delete(&parser);
  } else if (status == HETAB_OK) {
    status = hetab_fail(ctx, HETAB_ERR_MEMORY, "%s: out of memory", path);
  }
  return status;
}

void hetab_yaml_close(hetab_yaml *file) {
  yaml_document_delete(&file->document);
}

yaml_node_t *hetab_yaml_root(hetab_yaml *file) {
  return yaml_document_get_root_node(&file->document);
}

hetab_status hetab_yaml_locate(hetab_yaml *file, hetab_status status, const yaml_node_t *node,
                               const char *key) {
  char what[80];
  snprintf(what, sizeof what, "key %s", key);
  return hetab_locate(file->ctx, status, file->path, node->start_mark.line + 1, what);
}

hetab_status hetab_yaml_fail(hetab_yaml *file, const yaml_node_t *node, const char *key,
                             const char *format, ...) {
  char message[sizeof file->ctx->message];
  va_list args;
  va_start(args, format);
  vsnprintf(message, sizeof message, format, args);
  va_end(args);
  hetab_fail(file->ctx, HETAB_ERR_PARSE, "%s", message);
  return hetab_yaml_locate(file, HETAB_ERR_PARSE, node, key);
}

/* The text of a key; NULL for keys that are lists or mappings themselves. */
static const char *key_text(hetab_yaml *file, const yaml_node_pair_t *pair) {
  const yaml_node_t *key = yaml_document_get_node(&file->document, pair->key);
  return key->type == YAML_SCALAR_NODE ? (const char *)key->data.scalar.value : NULL;
}

static hetab_status check_known(hetab_yaml *file, const yaml_node_pair_t *pair,
                                const char *const *known) {
  const char *text = key_text(file, pair);
  for (const char *const *word = known; text && *word; word++)
    if (strcmp(text, *word) == 0)
      return HETAB_OK;
  const char *nearest = text ? hetab_nearest_word(text, known) : NULL;
  const yaml_node_t *key = yaml_document_get_node(&file->document, pair->key);
  if (nearest)
    return hetab_yaml_fail(file, key, text, "not known: did you mean %s?", nearest);
  char all[256] = "";
  for (; *known; known++)
    hetab_append_word(all, sizeof all, *known);
  return hetab_yaml_fail(file, key, text ? text : "?", "not known: the keys here are %s", all);
}

static hetab_status check_once(hetab_yaml *file, const yaml_node_t *mapping, const char *known) {
  size_t first_line = 0;
  const yaml_node_pair_t *pair = mapping->data.mapping.pairs.start;
  for (; pair < mapping->data.mapping.pairs.top; pair++) {
    const char *text = key_text(file, pair);
    if (!text || strcmp(text, known) != 0)
      continue;
    const yaml_node_t *key = yaml_document_get_node(&file->document, pair->key);
    if (first_line)
      return hetab_yaml_fail(file, key, known, "given already in line %zu: keep one", first_line);
    first_line = key->start_mark.line + 1;
  }
  return HETAB_OK;
}

hetab_status hetab_yaml_check_keys(hetab_yaml *file, const yaml_node_t *mapping,
                                   const char *const *known, bool strict) {
  const yaml_node_pair_t *pair = mapping->data.mapping.pairs.start;
  for (; strict && pair < mapping->data.mapping.pairs.top; pair++)
    HETAB_TRY(check_known(file, pair, known));
  for (; *known; known++)
    HETAB_TRY(check_once(file, mapping, *known));
  return HETAB_OK;
}

yaml_node_t *hetab_yaml_get(hetab_yaml *file, const yaml_node_t *mapping, const char *key) {
  const yaml_node_pair_t *pair = mapping->data.mapping.pairs.start;
  for (; pair < mapping->data.mapping.pairs.top; pair++) {
    const char *text = key_text(file, pair);
    if (text && strcmp(text, key) == 0)
      return yaml_document_get_node(&file->document, pair->value);
  }
  return NULL;
}

hetab_status hetab_yaml_require(hetab_yaml *file, const yaml_node_t *mapping, const char *key,
                                const char *remedy, yaml_node_t **value) {
  *value = hetab_yaml_get(file, mapping, key);
  return *value ? HETAB_OK : hetab_yaml_fail(file, mapping, key, "missing: %s", remedy);
}

static const char *type_name(const yaml_node_t *node) {
  switch (node->type) {
  case YAML_SCALAR_NODE:
    return "a single value";
  case YAML_SEQUENCE_NODE:
    return "a list";
  default:
    return "a mapping";
  }
}

hetab_status hetab_yaml_text(hetab_yaml *file, const yaml_node_t *node, const char *key,
                             const char *wanted, const char **text) {
  if (node->type != YAML_SCALAR_NODE)
    return hetab_yaml_fail(file, node, key, "is %s: give %s", type_name(node), wanted);
  const char *value = (const char *)node->data.scalar.value;
  if (*value == '\0')
    return hetab_yaml_fail(file, node, key, "is empty: give %s", wanted);
  if (strlen(value) != node->data.scalar.length) /* "\0" in quotes */
    return hetab_yaml_fail(file, node, key, "holds a NUL character: give %s", wanted);
  *text = value;
  return HETAB_OK;
}

hetab_status hetab_yaml_number(hetab_yaml *file, const yaml_node_t *node, const char *key,
                               const hetab_rule *rule, double *value) {
  const char *text = NULL;
  HETAB_TRY(hetab_yaml_text(file, node, key, rule->wanted, &text));
  hetab_status status = hetab_number_read(file->ctx, text, rule, value);
  return status == HETAB_OK ? HETAB_OK : hetab_yaml_locate(file, status, node, key);
}

hetab_status hetab_yaml_bool(hetab_yaml *file, const yaml_node_t *node, const char *key,
                             bool *value) {
  const char *text = NULL;
  HETAB_TRY(hetab_yaml_text(file, node, key, "true or false", &text));
  if (strcmp(text, "true") != 0 && strcmp(text, "false") != 0)
    return hetab_yaml_fail(file, node, key, "'%.40s' is not understood: give true or false", text);
  *value = strcmp(text, "true") == 0;
  return HETAB_OK;
}

hetab_status hetab_yaml_numbers(hetab_yaml *file, const yaml_node_t *sequence, const char *key,
                                const hetab_rule *rule, double **values, size_t *count) {
  const yaml_node_item_t *items = sequence->data.sequence.items.start;
  size_t length = (size_t)(sequence->data.sequence.items.top - items);
  double *numbers = hetab_alloc(file->ctx, length, sizeof *numbers);
  HETAB_NEED(numbers);
  for (size_t i = 0; i < length; i++) {
    const yaml_node_t *item = yaml_document_get_node(&file->document, items[i]);
    hetab_status status = hetab_yaml_number(file, item, key, rule, &numbers[i]);
    if (status != HETAB_OK) {
      free(numbers);
      return status;
    }
  }
  *values = numbers;
  *count = length;
  return HETAB_OK;
}
