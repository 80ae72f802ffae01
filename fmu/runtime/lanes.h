/* Arithmetic on WMR_LANES doubles at once, for kernels written for lanes: one robot a lane.
   Every function is right to 2 ulp wherever the scalar kernels use it, keeps infinities and NaN, and
   gives the same bits for any number of lanes.  GCC's vector types, which Clang knows too. */
#ifndef WMR_LANES_H
#define WMR_LANES_H

#include <float.h>
#include <math.h>
#include <stdint.h>

#if FLT_EVAL_METHOD == 2
#error "lanes need arithmetic in doubles, which this processor's x87 unit does not do: use SSE2"
#endif

#if defined(__AVX__)
#include <immintrin.h>
#endif

#ifndef WMR_LANES
#define WMR_LANES 2
#endif

#define WMR_INF ((double)INFINITY)
#define WMR_NAN ((double)NAN)

typedef double wmr_v __attribute__((vector_size(8 * WMR_LANES)));
typedef int64_t wmr_m __attribute__((vector_size(8 * WMR_LANES))); /* all bits of a lane, or none */

static inline wmr_v wmr_all(double a)
{
    wmr_v all = {0.0};
    return all + a; /* -0.0 becomes 0.0 */
}

static inline wmr_m wmr_bits(int64_t a)
{
    wmr_m all = {0};
    return all + a;
}

static inline wmr_v wmr_choose(wmr_m which, wmr_v yes, wmr_v no)
{
    return (wmr_v)(((wmr_m)yes & which) | ((wmr_m)no & ~which));
}

/* The same between truth values. */
static inline wmr_m wmr_pick(wmr_m which, wmr_m yes, wmr_m no)
{
    return (yes & which) | (no & ~which);
}

/* Whether any lane is chosen. */
static inline int wmr_some(wmr_m which)
{
#if WMR_LANES == 8 && defined(__AVX512F__)
    return _mm512_test_epi64_mask((__m512i)which, (__m512i)which) != 0;
#elif WMR_LANES == 4 && defined(__AVX__)
    return _mm256_movemask_pd((__m256d)which) != 0;
#else
    int64_t any = 0;
    for (int i = 0; i < WMR_LANES; ++i) {
        any |= which[i];
    }
    return any != 0;
#endif
}

static inline wmr_v wmr_sqrt(wmr_v a)
{
#if WMR_LANES == 8 && defined(__AVX512F__)
    return (wmr_v)_mm512_sqrt_pd((__m512d)a);
#elif WMR_LANES == 4 && defined(__AVX__)
    return (wmr_v)_mm256_sqrt_pd((__m256d)a);
#else
    for (int i = 0; i < WMR_LANES; ++i) {
        a[i] = sqrt(a[i]);
    }
    return a;
#endif
}

#define WMR_SIGN_BIT INT64_MIN

static inline wmr_v wmr_abs(wmr_v a) { return (wmr_v)((wmr_m)a & wmr_bits(INT64_MAX)); }
static inline wmr_v wmr_min(wmr_v a, wmr_v b) { return wmr_choose((wmr_m)(a < b), a, b); }
static inline wmr_v wmr_max(wmr_v a, wmr_v b) { return wmr_choose((wmr_m)(a > b), a, b); }
static inline wmr_v wmr_number(wmr_m truth) { return (wmr_v)(truth & (wmr_m)wmr_all(1.0)); }
static inline wmr_m wmr_truth(wmr_v a) { return (wmr_m)(a != 0.0); }
static inline wmr_m wmr_finite(wmr_v a) { return (wmr_m)(wmr_abs(a) < WMR_INF); }

static inline wmr_v wmr_copysign(wmr_v size, wmr_v sign)
{
    return (wmr_v)(((wmr_m)size & wmr_bits(INT64_MAX)) | ((wmr_m)sign & wmr_bits(WMR_SIGN_BIT)));
}

static inline wmr_v wmr_sign(wmr_v a)
{
    const wmr_v one = wmr_copysign(wmr_all(1.0), a);
    return wmr_choose((wmr_m)((a < 0.0) | (a > 0.0)), one, a);
}

/* Adding this rounds to an integer, which then stands in the low bits. */
#define WMR_ROUNDER 6755399441055744.0

static inline wmr_m wmr_integer(wmr_v shifted)
{
    return (wmr_m)shifted - (wmr_m)wmr_all(WMR_ROUNDER);
}

/* 2^k for -1022 <= k <= 1023 */
static inline wmr_v wmr_power(wmr_m k) { return (wmr_v)((k + 1023) << 52); }

static inline wmr_v wmr_exp(wmr_v a)
{
    const wmr_v high = wmr_choose((wmr_m)(a > 710.0), wmr_all(710.0), a);
    const wmr_v x = wmr_choose((wmr_m)(high < -746.0), wmr_all(-746.0), high);
    const wmr_v shifted = x * 1.44269504088896338700 + WMR_ROUNDER;
    const wmr_v n = shifted - WMR_ROUNDER;
    const wmr_v r = (x - n * 6.93147180369123816490e-01) - n * 1.90821492927058770002e-10;
    const wmr_v r2 = r * r, r4 = r2 * r2;
    /* Taylor to r^13 */
    const wmr_v p01 = r * (1.0 / 6.0) + 0.5, p23 = r * (1.0 / 120.0) + 1.0 / 24.0;
    const wmr_v p45 = r * (1.0 / 5040.0) + 1.0 / 720.0;
    const wmr_v p67 = r * (1.0 / 362880.0) + 1.0 / 40320.0;
    const wmr_v p89 = r * (1.0 / 39916800.0) + 1.0 / 3628800.0;
    const wmr_v pab = r * (1.0 / 6227020800.0) + 1.0 / 479001600.0;
    const wmr_v low = p01 + r2 * p23, middle = p45 + r2 * p67, top = p89 + r2 * pab;
    const wmr_v p = low + r4 * (middle + r4 * top);
    const wmr_v value = 1.0 + (r + r2 * p);
    const wmr_m k = wmr_integer(shifted), half = k >> 1;
    return (value * wmr_power(half)) * wmr_power(k - half);
}

/* Also for denormal numbers; log 0 = -inf, NaN below. */
static inline wmr_v wmr_log(wmr_v a)
{
    const wmr_m tiny = (wmr_m)(a < 2.2250738585072014e-308);
    const wmr_v x = wmr_choose(tiny, a * 18014398509481984.0, a);
    const wmr_m lifted = (wmr_m)x - 0x3fe6a09e667f3bcdLL;
    const wmr_m k = lifted >> 52;
    const wmr_v m = (wmr_v)((wmr_m)x - (k << 52)); /* sqrt(1/2) to sqrt(2) */
    wmr_v e = (wmr_v)((wmr_m)wmr_all(WMR_ROUNDER) + k) - WMR_ROUNDER;
    e -= (wmr_v)(tiny & (wmr_m)wmr_all(54.0));
    const wmr_v f = m - 1.0, s = f / (2.0 + f), z = s * s, w = z * z;
    const wmr_v even = w * (3.999999999940941908e-01
                            + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
    const wmr_v odd = z * (6.666666666666735130e-01
                           + w * (2.857142874366239149e-01
                                  + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
    const wmr_v half = 0.5 * f * f, rest = s * (half + (even + odd));
    const wmr_v found = e * 6.93147180369123816490e-01
                      - ((half - (rest + e * 1.90821492927058770002e-10)) - f);
    const wmr_v special = wmr_choose((wmr_m)(a == 0.0), wmr_all(-WMR_INF),
                                     wmr_choose((wmr_m)(a > 0.0), a, wmr_all(WMR_NAN)));
    return wmr_choose((wmr_m)(a > 0.0) & (wmr_m)(a < WMR_INF), found, special);
}

/* Beyond this the reduction by three parts of pi/2 loses digits: lane by lane with libm. */
#define WMR_ANGLE_MAX 1000.0

static inline wmr_v wmr_reduced(wmr_v a, wmr_m *quarter)
{
    const wmr_v shifted = a * 6.36619772367581382433e-01 + WMR_ROUNDER;
    const wmr_v n = shifted - WMR_ROUNDER;
    *quarter = wmr_integer(shifted);
    return ((a - n * 1.57079632673412561417e+00) - n * 6.07710050630396597660e-11)
         - n * 2.02226624879595063154e-21;
}

static inline wmr_v wmr_sine_part(wmr_v r)
{
    const wmr_v z = r * r, w = z * z;
    const wmr_v high = (2.75573137070700676789e-06 - z * 2.50507602534068634195e-08)
                     + w * 1.58969099521155010221e-10;
    const wmr_v low = 8.33333333332248946124e-03 - z * 1.98412698298579493134e-04;
    return r + (z * r) * (-1.66666666666666324348e-01 + z * (low + w * high));
}

static inline wmr_v wmr_cosine_part(wmr_v r)
{
    const wmr_v z = r * r, w = z * z, half = 0.5 * z, first = 1.0 - half;
    const wmr_v low = 4.16666666666666019037e-02
                    + z * (-1.38888888888741095749e-03 + z * 2.48015872894767294178e-05);
    const wmr_v high = -2.75573143513906633035e-07
                     + z * (2.08757232129817482790e-09 - z * 1.13596475577881948265e-11);
    return first + (((1.0 - first) - half) + w * (low + (z * w) * high));
}

/* The sine `turned` quarter turns on. */
static inline wmr_v wmr_turned_sine(wmr_v a, int turned)
{
    wmr_m quarter;
    const wmr_v r = wmr_reduced(a, &quarter);
    const wmr_m place = quarter + turned;
    const wmr_m odd = (wmr_m)((place & 1) != 0);
    const wmr_v size = wmr_choose(odd, wmr_cosine_part(r), wmr_sine_part(r));
    return (wmr_v)((wmr_m)size ^ ((place & 2) << 62));
}

static inline wmr_v wmr_sin(wmr_v a)
{
    wmr_v found = wmr_turned_sine(a, 0);
    if (wmr_some(~(wmr_m)(wmr_abs(a) < WMR_ANGLE_MAX))) {
        for (int i = 0; i < WMR_LANES; ++i) {
            found[i] = fabs(a[i]) < WMR_ANGLE_MAX ? found[i] : sin(a[i]);
        }
    }
    return found;
}

static inline wmr_v wmr_cos(wmr_v a)
{
    wmr_v found = wmr_turned_sine(a, 1);
    if (wmr_some(~(wmr_m)(wmr_abs(a) < WMR_ANGLE_MAX))) {
        for (int i = 0; i < WMR_LANES; ++i) {
            found[i] = fabs(a[i]) < WMR_ANGLE_MAX ? found[i] : cos(a[i]);
        }
    }
    return found;
}

/* As in wmr_math.h. */
static inline wmr_v wmr_tanh(wmr_v a)
{
    const wmr_v size = wmr_abs(a), z = a * a;
    const wmr_m small = (wmr_m)(size < 0.625);
    wmr_v found = wmr_copysign(1.0 - 2.0 / (wmr_exp(2.0 * size) + 1.0), a);
    if (wmr_some(small)) {
        const wmr_v over = (-9.64399179425052238628e-1 * z - 9.92877231001918586564e1) * z
                         - 1.61468768441708447952e3;
        const wmr_v under = ((z + 1.12811678491632931402e2) * z + 2.23548839060100448583e3) * z
                          + 4.84406305325125486048e3;
        found = wmr_choose(small, a + a * (z * (over / under)), found);
    }
    return found;
}

/* The rest lane by lane, with libm. */
#define WMR_EACH(name)                            \
    static inline wmr_v wmr_##name(wmr_v a)       \
    {                                             \
        for (int i = 0; i < WMR_LANES; ++i) {     \
            a[i] = name(a[i]);                    \
        }                                         \
        return a;                                 \
    }
#define WMR_EACH_PAIR(name)                           \
    static inline wmr_v wmr_##name(wmr_v a, wmr_v b)  \
    {                                                 \
        for (int i = 0; i < WMR_LANES; ++i) {         \
            a[i] = name(a[i], b[i]);                  \
        }                                             \
        return a;                                     \
    }

WMR_EACH(log1p)
WMR_EACH(expm1)
WMR_EACH(tan)
WMR_EACH(asin)
WMR_EACH(acos)
WMR_EACH(atan)
WMR_EACH(sinh)
WMR_EACH(cosh)
WMR_EACH(floor)
WMR_EACH(ceil)
WMR_EACH_PAIR(atan2)
WMR_EACH_PAIR(hypot)
WMR_EACH_PAIR(pow)

#endif
