/* The device's multiply-add rate, for the benchmark's roofline: independent chains in registers. */
#define HETAB_CL
#include "hetab_lang.h"
#include "tables.h"

/* Each work-item does rounds * HETAB_PEAK_CHAINS * HETAB_VW multiply-adds. */
__kernel void hetab_k_peak(int rounds, real factor, __global real *out) {
  vreal chain[HETAB_PEAK_CHAINS];
#pragma unroll
  for (int c = 0; c < HETAB_PEAK_CHAINS; c++)
    chain[c] = (vreal)(real)(get_global_id(0) + c);
  for (int i = 0; i < rounds; i++)
#pragma unroll
    for (int c = 0; c < HETAB_PEAK_CHAINS; c++)
      chain[c] = fma(chain[c], (vreal)factor, (vreal)factor);
  vreal sum = chain[0];
#pragma unroll
  for (int c = 1; c < HETAB_PEAK_CHAINS; c++)
    sum += chain[c];
  V_STORE(sum, get_global_id(0), out);
}
