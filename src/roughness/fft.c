#include "roughness/fft.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

static void fill_tables(hetab_fft *fft) {
  for (size_t k = 0; k < fft->size / 2 && !hetab_stopping_at(fft->ctx, k + 1); k++) {
    double angle = -2 * M_PI * (double)k / (double)fft->size;
    fft->roots[k] = (hetab_complex){cos(angle), sin(angle)};
  }
  for (size_t i = 0, reversed = 0; i < fft->size; i++) {
    fft->bins[i] = reversed;
    size_t bit = fft->size >> 1;
    for (; reversed & bit; bit >>= 1)
      reversed ^= bit;
    reversed |= bit;
  }
}

hetab_status hetab_fft_create(hetab_context *ctx, size_t length, hetab_fft *fft) {
  *fft = (hetab_fft){.size = 2, .ctx = ctx};
  while (fft->size < length && fft->size <= SIZE_MAX / 4)
    fft->size *= 2;
  fft->roots = hetab_alloc(ctx, fft->size / 2, sizeof *fft->roots);
  fft->bins = hetab_alloc(ctx, fft->size, sizeof *fft->bins);
  if (!fft->roots || !fft->bins) {
    hetab_fft_free(fft);
    return HETAB_ERR_MEMORY;
  }
  fill_tables(fft);
  return HETAB_OK;
}

void hetab_fft_free(hetab_fft *fft) {
  free(fft->roots);
  free(fft->bins);
  *fft = (hetab_fft){0};
}

/* Decimation in frequency. */
void hetab_fft_forward(const hetab_fft *fft, hetab_complex *data) {
  for (size_t half = fft->size / 2, stride = 1; half && !hetab_stopping_at(fft->ctx, fft->size);
       half /= 2, stride *= 2)
    for (size_t start = 0; start < fft->size; start += 2 * half)
      for (size_t k = 0; k < half; k++) {
        hetab_complex *a = &data[start + k], *b = a + half, w = fft->roots[k * stride];
        double re = a->re - b->re, im = a->im - b->im;
        *a = (hetab_complex){a->re + b->re, a->im + b->im};
        *b = (hetab_complex){re * w.re - im * w.im, re * w.im + im * w.re};
      }
}

/* Decimation in time, with the conjugate roots. */
void hetab_fft_inverse(const hetab_fft *fft, hetab_complex *data) {
  for (size_t half = 1, stride = fft->size / 2;
       half < fft->size && !hetab_stopping_at(fft->ctx, fft->size); half *= 2, stride /= 2)
    for (size_t start = 0; start < fft->size; start += 2 * half)
      for (size_t k = 0; k < half; k++) {
        hetab_complex *a = &data[start + k], *b = a + half, w = fft->roots[k * stride];
        double re = b->re * w.re + b->im * w.im, im = b->im * w.re - b->re * w.im;
        *b = (hetab_complex){a->re - re, a->im - im};
        *a = (hetab_complex){a->re + re, a->im + im};
      }
  for (size_t i = 0; i < fft->size; i++) {
    data[i].re /= (double)fft->size;
    data[i].im /= (double)fft->size;
  }
}
