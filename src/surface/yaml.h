/* A thin layer over libyaml's document API: typed look-ups whose failures read
 * "FILE:LINE: key KEY: what is wrong: remedy". */
#pragma once

#include <stdbool.h>
#include <yaml.h>
#include "core/number.h"

/* The document keeps aliases as references to one node, so an alias bomb does not grow. */
typedef struct hetab_yaml {
  hetab_context *ctx;
  const char *path; /* as the user gave it, for messages */
  yaml_document_t document;
} hetab_yaml;

/* A file with one document whose root is a mapping. Close after success only. */
hetab_status hetab_yaml_open(hetab_context *ctx, const char *path, hetab_yaml *file);
void hetab_yaml_close(hetab_yaml *file);
yaml_node_t *hetab_yaml_root(hetab_yaml *file);

/* Record "PATH:LINE: key KEY: ..." with the line of `node`. */
hetab_status hetab_yaml_fail(hetab_yaml *file, const yaml_node_t *node, const char *key,
                             const char *format, ...) __attribute__((format(printf, 4, 5)));
/* Put "PATH:LINE: key KEY: " before the message that the context holds; returns status. */
hetab_status hetab_yaml_locate(hetab_yaml *file, hetab_status status, const yaml_node_t *node,
                               const char *key);

/* Refuse a known key (the list ends in NULL) that occurs twice and, if strict, unknown keys. */
hetab_status hetab_yaml_check_keys(hetab_yaml *file, const yaml_node_t *mapping,
                                   const char *const *known, bool strict);
/* The value of a key, or NULL. */
yaml_node_t *hetab_yaml_get(hetab_yaml *file, const yaml_node_t *mapping, const char *key);
/* The value of a key that has to be there; `remedy` says what to write. */
hetab_status hetab_yaml_require(hetab_yaml *file, const yaml_node_t *mapping, const char *key,
                                const char *remedy, yaml_node_t **value);

/* The text of a scalar, owned by the document. `wanted` says what the key takes. */
hetab_status hetab_yaml_text(hetab_yaml *file, const yaml_node_t *node, const char *key,
                             const char *wanted, const char **text);
hetab_status hetab_yaml_number(hetab_yaml *file, const yaml_node_t *node, const char *key,
                               const hetab_rule *rule, double *value);
hetab_status hetab_yaml_bool(hetab_yaml *file, const yaml_node_t *node, const char *key,
                             bool *value);
/* A sequence of numbers; free() *values. */
hetab_status hetab_yaml_numbers(hetab_yaml *file, const yaml_node_t *sequence, const char *key,
                                const hetab_rule *rule, double **values, size_t *count);
