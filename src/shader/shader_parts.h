/* Texts of the model: templates in which @NAME@ stands for a part. */
#pragma once

#include <stdio.h>

#include <hetab/shader.h>

/* The templates, by scripts/embed_files from src/shader/; a NULL name ends them. */
typedef struct hetab_shader_template {
  const char *name, *text;
} hetab_shader_template;
extern const hetab_shader_template hetab_shader_templates[];

/* What a part is made of. */
typedef struct hetab_shader_input {
  hetab_context *ctx;
  const hetab_surface *surface; /* NULL: none */
} hetab_shader_input;

typedef hetab_status (*hetab_shader_part_fn)(const hetab_shader_input *input, FILE *out);

/* The part of a name's first `length` characters; NULL: there is none. */
hetab_shader_part_fn hetab_shader_part(const char *name, size_t length);

/* Bands of 400:700:10 nm and their weights of linear sRGB under D65, for spectra like reflectances
 * of metals; `count` is 8 or 16. Error, relative to luminance, over random surfaces and angles of
 * luminance above 1e-4: 0.6 % and 0.05 % (tests/test_shader.c). */
typedef struct hetab_colour_node {
  int nm;
  double rgb[3];
} hetab_colour_node;
const hetab_colour_node *hetab_colour_nodes(size_t count);
