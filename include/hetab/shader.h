/* The model as source text for other places: renderers, browsers, other languages. Each text is one
 * self-contained file with the table of h(g, x) in it, that holds for every surface; what error the
 * table adds is measured when the text is made, and stands in its head. */
#pragma once

#include <hetab/surface.h>

HETAB_BEGIN

typedef enum hetab_shader_language {
  HETAB_SHADER_C,       /* C99 and C++, in float */
  HETAB_SHADER_GLSL,    /* GLSL ES 3.00 and later; the table is for a texture */
  HETAB_SHADER_PYTHON,  /* numpy */
  HETAB_SHADER_MITSUBA, /* the above with `he_torrance`, a material of Mitsuba 3 */
  HETAB_SHADER_HTML     /* a page on which the model is explored, for browsers with WebGL 2 */
} hetab_shader_language;

/* f_dd, rho_s, f_ud, sampling and its density, with free parameters; a surface's own are in it by
 * name if it is not NULL. free() *text.
 * Error against the printed equations between directions that are single floats, up to 89.5 degrees
 * and tau = 110 lambda, where h is above 1e-6 of its peak: 5e-5 (tests/test_python.py; Mitsuba 3:
 * tests/renderers/live.py). */
hetab_status hetab_shader_text(hetab_context *ctx, const hetab_surface *surface,
                               hetab_shader_language language, char **text);

HETAB_END
