#include "noise.h"

#define ROUNDS 10
#define ATTEMPTS 64

#define TWO_PI 6.283185307179586

/* High and low half of a 64 by 64 bit product; from 32-bit pieces where there is no wider type. */
#ifdef __SIZEOF_INT128__
__extension__ typedef unsigned __int128 wide;

static uint64_t multiply(uint64_t a, uint64_t b, uint64_t *high)
{
    const wide product = (wide)a * b;
    *high = (uint64_t)(product >> 64);
    return (uint64_t)product;
}
#else
static uint64_t multiply(uint64_t a, uint64_t b, uint64_t *high)
{
    const uint64_t mask = 0xffffffffu;
    const uint64_t a0 = a & mask, a1 = a >> 32, b0 = b & mask, b1 = b >> 32;
    const uint64_t low = a0 * b0, middle = a1 * b0 + (low >> 32), cross = a0 * b1 + (middle & mask);
    *high = a1 * b1 + (middle >> 32) + (cross >> 32);
    return a * b;
}
#endif

void wmr_philox(const uint64_t counter[4], const uint64_t key[2], uint64_t out[4])
{
    uint64_t c0 = counter[0], c1 = counter[1], c2 = counter[2], c3 = counter[3];
    uint64_t k0 = key[0], k1 = key[1];
    for (int round = 0; round < ROUNDS; ++round) {
        uint64_t high0, high1;
        const uint64_t low0 = multiply(0xD2E7470EE14C6C93u, c0, &high0);
        const uint64_t low1 = multiply(0xCA5A826395121157u, c2, &high1);
        c0 = high1 ^ c1 ^ k0;
        c1 = low1;
        c2 = high0 ^ c3 ^ k1;
        c3 = low0;
        k0 += 0x9E3779B97F4A7C15u;
        k1 += 0xBB67AE8584CAA73Bu;
    }
    out[0] = c0;
    out[1] = c1;
    out[2] = c2;
    out[3] = c3;
}

/* The first two words of each element's block as 53-bit numbers on [0, 1). */
static void uniforms(const uint64_t *key, uint64_t k, uint64_t stream, uint64_t attempt, wmr_v u[2])
{
    const uint64_t counter[4] = {k, stream, attempt, 0};
    for (int i = 0; i < WMR_WIDTH; ++i) {
        uint64_t words[4];
        wmr_philox(counter, key + 2 * i, words);
        WMR_AT(u[0], i) = (double)(int64_t)(words[0] >> 11) * 0x1p-53;
        WMR_AT(u[1], i) = (double)(int64_t)(words[1] >> 11) * 0x1p-53;
    }
}

void wmr_uniform_pair(const uint64_t *key, uint64_t k, uint64_t stream, wmr_v out[2])
{
    uniforms(key, k, stream, 0, out);
    out[0] = 2.0 * out[0] - 1.0;
    out[1] = 2.0 * out[1] - 1.0;
}

void wmr_torque_noise(const uint64_t *key, uint64_t k, wmr_v std, wmr_v truncate, wmr_v out[2])
{
    wmr_v u[2], normal[2] = {wmr_all(0.0), wmr_all(0.0)};
    wmr_m open = wmr_always();
    for (uint64_t attempt = 0; attempt < ATTEMPTS && wmr_some(open); ++attempt) {
        uniforms(key, k, WMR_STREAM_TORQUE, attempt, u);
        const wmr_v radius = wmr_sqrt(-2.0 * wmr_log(1.0 - u[0])), angle = TWO_PI * u[1];
        normal[0] = wmr_choose(open, radius * wmr_cos(angle), normal[0]);
        normal[1] = wmr_choose(open, radius * wmr_sin(angle), normal[1]);
        open &= wmr_mask(wmr_abs(normal[0]) > truncate) | wmr_mask(wmr_abs(normal[1]) > truncate);
    }
    out[0] = std * wmr_max(-truncate, wmr_min(truncate, normal[0]));
    out[1] = std * wmr_max(-truncate, wmr_min(truncate, normal[1]));
}
