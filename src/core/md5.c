#include "core/md5.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

static uint32_t rotate(uint32_t x, int bits) {
  return x << bits | x >> (32 - bits);
}

enum { STEPS = 64 };

/* One block of 64 bytes, with the RFC's names; sines[i]: 2^32 |sin(i + 1)|. */
static void add_block(uint32_t state[4], const uint32_t sines[STEPS], const unsigned char *block) {
  static const int shifts[4][4] = {
      {7, 12, 17, 22}, {5, 9, 14, 20}, {4, 11, 16, 23}, {6, 10, 15, 21}};
  uint32_t words[16], a = state[0], b = state[1], c = state[2], d = state[3];
  for (int i = 0; i < 16; i++)
    words[i] = (uint32_t)block[4 * i] | (uint32_t)block[4 * i + 1] << 8 |
               (uint32_t)block[4 * i + 2] << 16 | (uint32_t)block[4 * i + 3] << 24;
  for (int i = 0; i < STEPS; i++) {
    int round = i / 16;
    uint32_t f = round == 0   ? (b & c) | (~b & d)
                 : round == 1 ? (d & b) | (~d & c)
                 : round == 2 ? b ^ c ^ d
                              : c ^ (b | ~d);
    int word = round == 0 ? i : round == 1 ? 5 * i + 1 : round == 2 ? 3 * i + 5 : 7 * i;
    uint32_t sum = a + f + sines[i] + words[word % 16];
    a = d;
    d = c;
    c = b;
    b += rotate(sum, shifts[round][i % 4]);
  }
  state[0] += a;
  state[1] += b;
  state[2] += c;
  state[3] += d;
}

void hetab_md5(const void *data, size_t size, char digest[33]) {
  uint32_t state[4] = {0x67452301, 0xefcdab89, 0x98badcfe, 0x10325476}, sines[STEPS];
  const unsigned char *bytes = data;
  size_t whole = size / 64 * 64, left = size - whole;
  for (int i = 0; i < STEPS; i++)
    sines[i] = (uint32_t)(4294967296.0 * fabs(sin(i + 1)));
  for (size_t i = 0; i < whole; i += 64)
    add_block(state, sines, bytes + i);
  unsigned char tail[128] = {0};
  if (left)
    memcpy(tail, bytes + whole, left);
  tail[left] = 0x80;
  size_t end = left < 56 ? 64 : 128;
  for (int i = 0; i < 8; i++)
    tail[end - 8 + (size_t)i] = (unsigned char)((uint64_t)size * 8 >> 8 * i);
  for (size_t i = 0; i < end; i += 64)
    add_block(state, sines, tail + i);
  for (int i = 0; i < 16; i++)
    snprintf(digest + 2 * i, 3, "%02x", state[i / 4] >> 8 * (i % 4) & 0xff);
}
