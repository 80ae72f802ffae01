/* Counter-based noise: Philox4x64-10, so that sample k of any run can be drawn by itself, in any
   order, on any platform, with the same bits. */
#ifndef WMR_NOISE_H
#define WMR_NOISE_H

#include "arithmetic.h"

enum { WMR_STREAM_TORQUE = 0, WMR_STREAM_POSE = 1, WMR_STREAM_VELOCITY = 2 };

/* Four 64-bit words of the block at `counter` under `key`. */
void wmr_philox(const uint64_t counter[4], const uint64_t key[2], uint64_t out[4]);

/* What follows draws for each element of a wmr_v: `key` holds WMR_WIDTH pairs. */

/* Two numbers of stream `stream` at sample k, uniform on [-1, 1). */
void wmr_uniform_pair(const uint64_t *key, uint64_t k, uint64_t stream, wmr_v out[2]);

/* Two independent N(0, std) numbers at sample k; beyond `truncate` standard deviations the pair
   is drawn again (INFINITY: never). */
void wmr_torque_noise(const uint64_t *key, uint64_t k, wmr_v std, wmr_v truncate, wmr_v out[2]);

#endif
