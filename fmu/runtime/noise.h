/* Counter-based noise: Philox4x64-10, so that sample k of any run can be drawn by itself, in any
   order, on any platform, with the same bits. */
#ifndef WMR_NOISE_H
#define WMR_NOISE_H

#include <stdint.h>

/* Four 64-bit words of the block at `counter` (sample or step, stream, attempt, pair) under `key`. */
void wmr_philox(const uint64_t counter[4], const uint64_t key[2], uint64_t out[4]);

#endif
