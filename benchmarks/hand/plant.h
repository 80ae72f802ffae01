/* Plant (1)-(6) with friction mu m g tanh(v1/v_s), and the torque noise. */
#ifndef WMR_HAND_PLANT_H
#define WMR_HAND_PLANT_H

#include "hand.h"

#include <math.h>

/* The turning rate is linear in time while the torque is held, so the angles of all four stages
 * are known at once; the rest is the classical scheme. */
static inline void rk4(const hand_plant *restrict p, double force, double moment,
                       double *restrict s)
{
    const double h = p->h, half = 0.5 * h, sixth = h / 6.0;
    const double turn = moment * p->inv_inertia, push = force * p->inv_m;
    const double w1 = s[4], w2 = w1 + half * turn, w4 = w1 + h * turn;
    const double th1 = s[2], th2 = th1 + half * w1, th3 = th1 + half * w2, th4 = th1 + h * w2;

    /* sines and cosines stand between the stages so that they overlap the chain of tanh */
    const double v1 = s[3], a1 = push - p->mu_g * tanh(v1 * p->inv_v_s);
    const double v2 = v1 + half * a1, s1 = sin(th1), c1 = cos(th1);
    const double a2 = push - p->mu_g * tanh(v2 * p->inv_v_s);
    const double v3 = v1 + half * a2, s2 = sin(th2), c2 = cos(th2);
    const double a3 = push - p->mu_g * tanh(v3 * p->inv_v_s);
    const double v4 = v1 + h * a3, s3 = sin(th3), c3 = cos(th3);
    const double a4 = push - p->mu_g * tanh(v4 * p->inv_v_s);
    const double s4 = sin(th4), c4 = cos(th4);

    s[0] -= sixth * (v1 * s1 + 2.0 * (v2 * s2 + v3 * s3) + v4 * s4);
    s[1] += sixth * (v1 * c1 + 2.0 * (v2 * c2 + v3 * c3) + v4 * c4);
    s[2] += sixth * (w1 + 4.0 * w2 + w4);
    s[3] += sixth * (a1 + 2.0 * (a2 + a3) + a4);
    s[4] = w4;
}

#define TWO_PI 6.283185307179586476925286766559

/* ---- noise: Philox4x64-10, Box-Muller ---- */

#ifdef __SIZEOF_INT128__
__extension__ typedef unsigned __int128 wide;
static inline uint64_t multiply(uint64_t a, uint64_t b, uint64_t *low)
{
    const wide product = (wide)a * b;
    *low = (uint64_t)product;
    return (uint64_t)(product >> 64);
}
#else
static inline uint64_t multiply(uint64_t a, uint64_t b, uint64_t *low)
{
    const uint64_t a0 = a & 0xFFFFFFFFu, a1 = a >> 32, b0 = b & 0xFFFFFFFFu, b1 = b >> 32;
    const uint64_t middle = a1 * b0 + ((a0 * b0) >> 32);
    const uint64_t other = a0 * b1 + (middle & 0xFFFFFFFFu);
    *low = a * b;
    return a1 * b1 + (middle >> 32) + (other >> 32);
}
#endif

static inline void philox(const uint64_t key[2], const uint64_t counter[4], uint64_t out[4])
{
    uint64_t k0 = key[0], k1 = key[1];
    uint64_t c0 = counter[0], c1 = counter[1], c2 = counter[2], c3 = counter[3];
    for (int i = 0; i < 10; i++) {
        uint64_t low0, low1;
        const uint64_t high0 = multiply(UINT64_C(0xD2E7470EE14C6C93), c0, &low0);
        const uint64_t high1 = multiply(UINT64_C(0xCA5A826395121157), c2, &low1);
        c0 = high1 ^ c1 ^ k0;
        c1 = low1;
        c2 = high0 ^ c3 ^ k1;
        c3 = low0;
        k0 += UINT64_C(0x9E3779B97F4A7C15);
        k1 += UINT64_C(0xBB67AE8584CAA73B);
    }
    out[0] = c0;
    out[1] = c1;
    out[2] = c2;
    out[3] = c3;
}

static inline void torque_noise(const hand_case *run, int64_t k, double noise[2])
{
    const uint64_t counter[4] = {(uint64_t)k, 0, 0, 0};
    uint64_t raw[4];
    philox(run->key, counter, raw);
    const double u0 = (double)(raw[0] >> 11) * 0x1p-53, u1 = (double)(raw[1] >> 11) * 0x1p-53;
    const double radius = run->noise_std * sqrt(-2.0 * log(1.0 - u0));
    noise[0] = radius * cos(TWO_PI * u1);
    noise[1] = radius * sin(TWO_PI * u1);
}

#endif
