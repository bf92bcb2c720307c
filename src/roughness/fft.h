/* The discrete Fourier transform of a power of two, for convolutions: spectra come in bit-reversed
 * order, which costs no permutation. */
#pragma once

#include "core/context.h"

typedef struct hetab_complex {
  double re, im;
} hetab_complex;

typedef struct hetab_fft {
  hetab_context *ctx; /* a long transform stops half-way where that asks to: hetab_stopping() */
  size_t size;
  hetab_complex *roots; /* [size / 2] exp(-2 pi i k / size) */
  size_t *bins;         /* [size] the frequency that spectrum[i] belongs to; its own inverse */
} hetab_fft;

/* The smallest power of two that is at least `length`, and at least 2. */
hetab_status hetab_fft_create(hetab_context *ctx, size_t length, hetab_fft *fft);
void hetab_fft_free(hetab_fft *fft);

void hetab_fft_forward(const hetab_fft *fft, hetab_complex *data);
/* The inverse, 1 / size included. */
void hetab_fft_inverse(const hetab_fft *fft, hetab_complex *data);
