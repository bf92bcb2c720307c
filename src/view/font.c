/* A stroke font. A glyph is strokes, separated by spaces, of points: a digit for x and a letter for
 * y, 'd' being the baseline, 'j' the height of x and 'l' that of capitals. After '~' comes a point
 * that the stroke only bends towards, as in TrueType: the control point of a quadratic spline, with
 * an implied point midway between two of them. */
#include "view/canvas.h"

static const char *const ascii[] = {
    "",                                         /* space */
    "0l0f 0d0d",                                /* ! */
    "0l0j 2l2j",                                /* " */
    "1d2l 3d4l 0f5f 0j5j",                      /* # */
    "5k~4l3l~0l~0h3h~5h~5d2d~1d0e 3m3c",        /* $ */
    "0d5l 1l~0l~0j~2j~2l1l 4f~3f~3d~5d~5f4f",   /* % */
    "5d1j~1l2l~3l3k~3i0f~0d2d~4d5g",            /* & */
    "0l0j",                                     /* ' */
    "2m~0j~0e2b",                               /* ( */
    "0m~2j~2e0b",                               /* ) */
    "2l2h 0k4i 0i4k",                           /* * */
    "2f2j 0h4h",                                /* + */
    "1d0b",                                     /* , */
    "0g3g",                                     /* - */
    "0d0d",                                     /* . */
    "0c4m",                                     /* / */
    "2d~0d~0l~4l~4d2d",                         /* 0 */
    "0j2l2d",                                   /* 1 */
    "0k~0l2l~4l4j~4h0d4d",                      /* 2 */
    "0k~0l2l~4l~4h2h1h 2h~4h~4d2d~0d0e",        /* 3 */
    "3d3l0f4f",                                 /* 4 */
    "4l0l0h~1i2i~4i4g~4d2d~0d0e",               /* 5 */
    "4k~3l2l~0l0g~0d2d~4d4f~4i2i~0i0g",         /* 6 */
    "0l4l1d",                                   /* 7 */
    "2h~0h~0l~4l~4h2h~0h~0d~4d~4h2h",           /* 8 */
    "0e~1d2d~4d4i~4l2l~0l0j~0g2g~4g4i",         /* 9 */
    "0d0d 0i0i",                                /* : */
    "1i1i 1d0b",                                /* ; */
    "4j0g4d",                                   /* < */
    "0f4f 0i4i",                                /* = */
    "0j4g0d",                                   /* > */
    "0k~0l2l~4l~4h2h2f 2d2d",                   /* ? */
    "4h~4j~2j~2f~4f4h~4f6f6h~6l3l~0l0h~0d3d5d", /* @ */
    "0d3l6d 1g5g",                              /* A */
    "0d0l3l~5l~5h3h0h 3h~6h~6d3d0d",            /* B */
    "5k~4l3l~0l0h~0d3d~4d5e",                   /* C */
    "0d0l2l~5l~5d2d0d",                         /* D */
    "4l0l0d4d 0h3h",                            /* E */
    "4l0l0d 0h3h",                              /* F */
    "5k~4l3l~0l0h~0d3d~5d5h3h",                 /* G */
    "0d0l 5d5l 0h5h",                           /* H */
    "0d0l",                                     /* I */
    "3l3f~3d1d~0d0e",                           /* J */
    "0d0l 5l0g 2i5d",                           /* K */
    "0l0d4d",                                   /* L */
    "0d0l3f6l6d",                               /* M */
    "0d0l5d5l",                                 /* N */
    "3d~0d~0l~6l~6d3d",                         /* O */
    "0d0l3l~5l~5h3h0h",                         /* P */
    "3d~0d~0l~6l~6d3d 4f6c",                    /* Q */
    "0d0l3l~5l~5h3h0h 3h5d",                    /* R */
    "5k~4l3l~0l~0h3h~5h~5d2d~1d0e",             /* S */
    "0l6l 3l3d",                                /* T */
    "0l0g~0d~5d5g5l",                           /* U */
    "0l3d6l",                                   /* V */
    "0l2d4l6d8l",                               /* W */
    "0d5l 0l5d",                                /* X */
    "0l3h6l 3h3d",                              /* Y */
    "0l5l0d5d",                                 /* Z */
    "2m0m0b2b",                                 /* [ */
    "0m4c",                                     /* \ */
    "0m2m2b0b",                                 /* ] */
    "0j2l4j",                                   /* ^ */
    "0c5c",                                     /* _ */
    "0l1k",                                     /* ` */
    "4j4d 4g~4j~0j~0d~4d4g",                    /* a */
    "0l0d 0g~0j~4j~4d~0d0g",                    /* b */
    "4i~3j2j~0j0g~0d2d~3d4e",                   /* c */
    "4l4d 4g~4j~0j~0d~4d4g",                    /* d */
    "0g4g~4j2j~0j0g~0d2d~3d4e",                 /* e */
    "3l~1l1j1d 0j3j",                           /* f */
    "4j4c~4a2a~1a0b 4g~4j~0j~0d~4d4g",          /* g */
    "0l0d 0g~0j2j~4j4g4d",                      /* h */
    "0j0d 0l0l",                                /* i */
    "1j1c~1a0a 1l1l",                           /* j */
    "0l0d 4j0f 1g4d",                           /* k */
    "0l0e~0d1d",                                /* l */
    "0j0d 0h~0j2j~3j3h3d 3h~3j5j~6j6h6d",       /* m */
    "0j0d 0g~0j2j~4j4g4d",                      /* n */
    "2d~0d~0j~4j~4d2d",                         /* o */
    "0j0a 0g~0j~4j~4d~0d0g",                    /* p */
    "4j4a 4g~4j~0j~0d~4d4g",                    /* q */
    "0j0d 0g~0j3j",                             /* r */
    "4i~3j2j~0j~0g2g~4g~4d2d~1d0e",             /* s */
    "1l1f~1d3d 0j3j",                           /* t */
    "0j0g~0d2d~4d4g 4j4d",                      /* u */
    "0j2d4j",                                   /* v */
    "0j1d3j5d6j",                               /* w */
    "0j4d 4j0d",                                /* x */
    "0j2d 4j1a",                                /* y */
    "0j4j0d4d",                                 /* z */
    "3m~1m1j~1g0g~1g1d~1b3b",                   /* { */
    "0b0m",                                     /* | */
    "0m~2m2j~2g3g~2g2d~2b0b",                   /* } */
    "0g~1i2g~3e4g",                             /* ~ */
};

static const struct {
  unsigned character;
  const char *strokes;
} others[] = {
    {0xb0, "1l~0l~0j~2j~2l1l"},       /* degree */
    {0xb5, "0j0a 0g~0d2d~4d4g 4j4d"}, /* micro */
    {0x3b8, "2d~0d~0l~4l~4d2d 0h4h"}, /* theta */
    {0x3bb, "0l~1l2h4d 2h0d"},        /* lambda */
    {0x3c1, "0a0g~0j~4j~4d~0d0g"},    /* rho */
    {0x3c3, "5j2j~0j~0d~4d4g~4j2j"},  /* sigma */
    {0x3c4, "0j4j 2j2f~2d3d"},        /* tau */
    {0x3c6, "2d~0d~0j~4j~4d2d 2l2a"}, /* phi */
    {0x1d62, "0a0e 0g0g"},            /* subscript i */
    {0x1d63, "0a0e 0c~0e2e"},         /* subscript r */
    {0x2080, "1a~0a~0e~2e~2a1a"},     /* subscript 0 */
};

const char *hetab_glyph(unsigned character) {
  if (character >= ' ' && character <= '~')
    return ascii[character - ' '];
  for (size_t i = 0; i < sizeof others / sizeof *others; i++)
    if (others[i].character == character)
      return others[i].strokes;
  return NULL;
}
