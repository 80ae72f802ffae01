/* Numbers and elementary functions of all generated code and of the loop: written once for one
   number (WMR_LANES 0, plain C99) and for WMR_LANES numbers side by side (2, 4 or 8; vector types
   of GCC and Clang).  An element's bits are the same either way, with every compiler and on every
   processor that keeps IEEE doubles: only + - * / and square roots round, no multiplication is
   fused with an addition (compile with -ffp-contract=off), and nothing comes from the C library
   but sqrt, fabs and copysign, which are exact.

   Infinities, NaN, signed zeros and denormal numbers are treated as in C99's Annex F.  Largest
   errors, in units in the last place: floor, ceil, sqrt none but rounding; exp, log, log1p, asin,
   acos, atan 1; expm1, sin, cos, tanh, cosh, atan2, hypot, pow 2; sinh, tan 3.  Coefficients are
   those of fdlibm (Sun Microsystems) and of Cephes (S. L. Moshier), but for exp. */
#ifndef WMR_ARITHMETIC_H
#define WMR_ARITHMETIC_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

/* Flags that let a compiler compute other values than those written, or assume that none is NaN.  Before
   version 12 GCC tells some of them only by __GCC_IEC_559, which is always 0 on some small processors.
   Clang has no macro for some of them: the pragma keeps the order of operations under these. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) \
    || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0) || defined(_M_FP_FAST) \
    || (defined(__GCC_IEC_559) && __GCC_IEC_559 == 0 && __GNUC__ < 12 && !defined(__clang__) \
        && (defined(__x86_64__) || defined(__aarch64__)))
#error "these formulas need IEEE arithmetic as written: compile without -ffast-math, -Ofast, -funsafe-math-optimizations, -fassociative-math, -freciprocal-math, -ffinite-math-only and /fp:fast"
#elif defined(__clang__) && __clang_major__ >= 13
#pragma clang fp reassociate(off) contract(off)
#endif

typedef char wmr_needs_doubles_compile_without_fsingle_precision_constant
    [sizeof(1.0) == sizeof(double) ? 1 : -1];

#if defined(DBL_MANT_DIG) && DBL_MANT_DIG != 53 /* analysers may not know it */
#error "this arithmetic needs doubles of 64 bits"
#endif
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD == 2
#error "this arithmetic needs rounding to doubles, not x87: use -msse2 -mfpmath=sse"
#endif

#ifndef WMR_LANES
#define WMR_LANES 0
#endif

#define WMR_INF ((double)INFINITY)
#define WMR_NAN ((double)NAN)

/* Powers of two: 2^52 and 2^-54, say.  C++ before 2017 has no hexadecimal ones. */
#define WMR_2M600 2.409919865102884e-181
#define WMR_2M450 3.4395525670743494e-136
#define WMR_2M54 5.551115123125783e-17
#define WMR_2M53 1.1102230246251565e-16
#define WMR_2M27 7.450580596923828e-09
#define WMR_2P37 137438953472.0
#define WMR_2P52 4503599627370496.0
#define WMR_2P53 9007199254740992.0
#define WMR_2P54 1.8014398509481984e+16
#define WMR_2P60 1.152921504606847e+18
#define WMR_2P500 3.273390607896142e+150
#define WMR_2P600 4.149515568880993e+180

/* What is seldom called and must not swell its callers. */
#if defined(__GNUC__)
#define WMR_RARE static __attribute__((noinline, cold, unused))
#else
#define WMR_RARE static inline
#endif

/* Types: wmr_v numbers, wmr_m truth values, wmr_i the bits of numbers.  wmr_some(m): whether m
   holds anywhere; WMR_AT(v, i): element i of WMR_WIDTH. */
#if WMR_LANES == 0

#define WMR_WIDTH 1
#define WMR_AT(v, i) (v)

typedef double wmr_v;
typedef int wmr_m; /* 0 or 1 */
typedef uint64_t wmr_i;

#define wmr_mask(comparison) ((wmr_m)(comparison))

static inline wmr_v wmr_all(double a) { return a; }
static inline wmr_m wmr_always(void) { return 1; }
static inline wmr_m wmr_never(void) { return 0; }
static inline wmr_m wmr_not(wmr_m m) { return !m; }
static inline wmr_m wmr_pick(wmr_m which, wmr_m yes, wmr_m no) { return which ? yes : no; }
static inline wmr_v wmr_choose(wmr_m which, wmr_v yes, wmr_v no) { return which ? yes : no; }
static inline wmr_v wmr_number(wmr_m truth) { return (double)truth; }
static inline int wmr_some(wmr_m m) { return m; }
static inline wmr_v wmr_sqrt(wmr_v a) { return sqrt(a); }
static inline wmr_v wmr_abs(wmr_v a) { return fabs(a); }
static inline wmr_v wmr_copysign(wmr_v size, wmr_v sign) { return copysign(size, sign); }

static inline wmr_i wmr_raw(wmr_v a)
{
    wmr_i bits;
    memcpy(&bits, &a, sizeof bits);
    return bits;
}

static inline wmr_v wmr_cooked(wmr_i bits)
{
    wmr_v a;
    memcpy(&a, &bits, sizeof a);
    return a;
}

#else

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#define WMR_WIDTH WMR_LANES
#define WMR_AT(v, i) ((v)[i])

typedef double wmr_v __attribute__((vector_size(8 * WMR_LANES)));
typedef int64_t wmr_m __attribute__((vector_size(8 * WMR_LANES))); /* all bits of a lane, or none */
typedef uint64_t wmr_i __attribute__((vector_size(8 * WMR_LANES)));

#define wmr_mask(comparison) ((wmr_m)(comparison))

#if WMR_LANES == 2
#define WMR_REPEATED(a) {a, a}
#elif WMR_LANES == 4
#define WMR_REPEATED(a) {a, a, a, a}
#elif WMR_LANES == 8
#define WMR_REPEATED(a) {a, a, a, a, a, a, a, a}
#else
#error "WMR_LANES is 0, 2, 4 or 8"
#endif

static inline wmr_v wmr_all(double a) { return (wmr_v)WMR_REPEATED(a); }
static inline wmr_m wmr_always(void) { return (wmr_m)WMR_REPEATED(-1); }
static inline wmr_m wmr_never(void) { return (wmr_m)WMR_REPEATED(0); }
static inline wmr_i wmr_raw(wmr_v a) { return (wmr_i)a; }
static inline wmr_v wmr_cooked(wmr_i bits) { return (wmr_v)bits; }
static inline wmr_m wmr_not(wmr_m m) { return ~m; }

static inline wmr_m wmr_pick(wmr_m which, wmr_m yes, wmr_m no)
{
    return (yes & which) | (no & ~which);
}

static inline wmr_v wmr_choose(wmr_m which, wmr_v yes, wmr_v no)
{
    return (wmr_v)(((wmr_m)yes & which) | ((wmr_m)no & ~which));
}

static inline wmr_v wmr_number(wmr_m truth) { return (wmr_v)(truth & (wmr_m)wmr_all(1.0)); }

static inline int wmr_some(wmr_m m)
{
#if WMR_LANES == 8 && defined(__AVX512F__)
    return _mm512_test_epi64_mask((__m512i)m, (__m512i)m) != 0;
#elif WMR_LANES == 4 && defined(__AVX__)
    return _mm256_movemask_pd((__m256d)m) != 0;
#elif WMR_LANES == 2 && defined(__SSE2__)
    return _mm_movemask_pd((__m128d)m) != 0;
#else
    int64_t any = 0;
    for (int i = 0; i < WMR_LANES; ++i) {
        any |= m[i];
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
#elif WMR_LANES == 2 && defined(__SSE2__)
    return (wmr_v)_mm_sqrt_pd((__m128d)a);
#else
    for (int i = 0; i < WMR_LANES; ++i) {
        a[i] = sqrt(a[i]);
    }
    return a;
#endif
}

static inline wmr_v wmr_abs(wmr_v a) { return (wmr_v)((wmr_m)a & INT64_MAX); }

static inline wmr_v wmr_copysign(wmr_v size, wmr_v sign)
{
    return (wmr_v)(((wmr_m)size & INT64_MAX) | ((wmr_m)sign & INT64_MIN));
}

#endif

/* Four numbers side by side.  Where a processor has vectors they are stored as one, so that a loop
   that loads them as one need not wait for each of them to reach the memory. */
#if WMR_LANES == 0 && defined(__GNUC__) && (defined(__SSE2__) || defined(__aarch64__))
typedef double wmr_row_of_four __attribute__((vector_size(32), aligned(8), may_alias));

static inline void wmr_four(wmr_v *to, wmr_v a, wmr_v b, wmr_v c, wmr_v d)
{
    const wmr_row_of_four row = {a, b, c, d};
    *(wmr_row_of_four *)to = row;
}
#else
static inline void wmr_four(wmr_v *to, wmr_v a, wmr_v b, wmr_v c, wmr_v d)
{
    to[0] = a;
    to[1] = b;
    to[2] = c;
    to[3] = d;
}
#endif

/* Smaller and larger of two; the second where one is NaN. */
static inline wmr_v wmr_min(wmr_v a, wmr_v b) { return wmr_choose(wmr_mask(a < b), a, b); }
static inline wmr_v wmr_max(wmr_v a, wmr_v b) { return wmr_choose(wmr_mask(a > b), a, b); }
static inline wmr_m wmr_truth(wmr_v a) { return wmr_mask(a != 0.0); }
static inline wmr_m wmr_finite(wmr_v a) { return wmr_mask(wmr_abs(a) < WMR_INF); }

/* -1, 1, or the number itself where it is 0 or NaN. */
static inline wmr_v wmr_sign(wmr_v a)
{
    const wmr_m other = wmr_mask(a < 0.0) | wmr_mask(a > 0.0);
    return wmr_choose(other, wmr_copysign(wmr_all(1.0), a), a);
}

/* Whether m holds nowhere, and everywhere. */
static inline int wmr_none(wmr_m m) { return !wmr_some(m); }
static inline int wmr_every(wmr_m m) { return !wmr_some(wmr_not(m)); }

/* The same with one NaN for all: processors differ in sign and content of those they make. */
static inline wmr_v wmr_one_nan(wmr_v a)
{
    const wmr_i none = wmr_raw(wmr_all(0.0));
    return wmr_choose(wmr_mask(a == a), a, wmr_cooked(none | UINT64_C(0x7ff8000000000000)));
}

static inline wmr_v wmr_floor(wmr_v a)
{
    const wmr_v size = wmr_abs(a), whole = wmr_copysign((size + WMR_2P52) - WMR_2P52, a);
    const wmr_v below = whole - wmr_number(wmr_mask(whole > a));
    return wmr_choose(wmr_mask(size < WMR_2P52), wmr_copysign(below, a), a);
}

static inline wmr_v wmr_ceil(wmr_v a) { return -wmr_floor(-a); }

/* Adding this rounds to an integer, which then stands in the low bits. */
#define WMR_ROUNDER 6755399441055744.0

/* 2^k, -1022 <= k <= 1023, of a number k + WMR_ROUNDER. */
static inline wmr_v wmr_power_of_two(wmr_v shifted)
{
    return wmr_cooked((wmr_raw(shifted) + 1023) << 52);
}

/* A number without its last 27 bits: products of two such are exact. */
static inline wmr_v wmr_high(wmr_v a)
{
    return wmr_cooked(wmr_raw(a) & UINT64_C(0xfffffffff8000000));
}

/* What a + b and a * b lost when they were rounded. */
static inline wmr_v wmr_sum_rest(wmr_v a, wmr_v b, wmr_v sum)
{
    const wmr_v part = sum - a;
    return (a - (sum - part)) + (b - part);
}

static inline wmr_v wmr_product_rest(wmr_v a, wmr_v b, wmr_v product)
{
    const wmr_v ah = wmr_high(a), bh = wmr_high(b), al = a - ah, bl = b - bh;
    return ((ah * bh - product) + (ah * bl + al * bh)) + al * bl;
}

/* ln 2 in two parts: multiples of the first by integers below 2^20 are exact. */
#define WMR_LN2_HIGH 6.93147180369123816490e-01
#define WMR_LN2_LOW 1.90821492927058770002e-10
#define WMR_PER_LN2 1.44269504088896338700

/* e^r - 1 - r for |r| < 0.35, to 2^-57 of e^r: the best polynomial of degree 11. */
static inline wmr_v wmr_exp_rest(wmr_v r)
{
    const wmr_v r2 = r * r, r4 = r2 * r2;
    const wmr_v p01 = r * 1.6666666666666433e-01 + 0.5;
    const wmr_v p23 = r * 8.33333333350125e-03 + 4.16666666666035e-02;
    const wmr_v p45 = r * 1.9841269464180965e-04 + 1.388888892700519e-03;
    const wmr_v p67 = r * 2.7557642022841833e-06 + 2.4801508393536655e-05;
    const wmr_v p89 = r * 2.497825197196261e-08 + 2.76253116562445e-07;
    return r2 * ((p01 + r2 * p23) + r4 * ((p45 + r2 * p67) + r4 * p89));
}

#define WMR_EXP_NEAR 700.0

/* exp where |a| < WMR_EXP_NEAR. */
static inline wmr_v wmr_exp_near(wmr_v a)
{
    const wmr_v shifted = a * WMR_PER_LN2 + WMR_ROUNDER, n = shifted - WMR_ROUNDER;
    const wmr_v r = (a - n * WMR_LN2_HIGH) - n * WMR_LN2_LOW;
    return (1.0 + (r + wmr_exp_rest(r))) * wmr_power_of_two(shifted);
}

/* e^a / 2^less anywhere: the power of two in two factors, neither beyond what numbers can be. */
static inline wmr_v wmr_exp_over(wmr_v a, double less)
{
    const wmr_v high = wmr_choose(wmr_mask(a > 712.0), wmr_all(712.0), a);
    const wmr_v x = wmr_choose(wmr_mask(high < -746.0), wmr_all(-746.0), high);
    const wmr_v n = (x * WMR_PER_LN2 + WMR_ROUNDER) - WMR_ROUNDER;
    const wmr_v r = (x - n * WMR_LN2_HIGH) - n * WMR_LN2_LOW;
    const wmr_v half = 0.5 * n + WMR_ROUNDER;
    const wmr_v other = ((n - (half - WMR_ROUNDER)) - less) + WMR_ROUNDER;
    const wmr_v value = 1.0 + (r + wmr_exp_rest(r));
    return (value * wmr_power_of_two(half)) * wmr_power_of_two(other);
}

static inline wmr_v wmr_exp_far(wmr_v a) { return wmr_exp_over(a, 0.0); }

static inline wmr_v wmr_exp(wmr_v a)
{
    if (wmr_every(wmr_mask(wmr_abs(a) < WMR_EXP_NEAR))) {
        return wmr_exp_near(a);
    }
    return wmr_exp_far(a);
}

/* The exponentials of several numbers in place: a loop without branches, which compilers turn into
   vector instructions. */
static inline void wmr_exp_many(wmr_v *a, int count)
{
    wmr_i inside = wmr_raw(wmr_all(-1.0));
    for (int i = 0; i < count; ++i) { /* a difference's sign: sizes are in order as integers too */
        inside &= wmr_raw(wmr_abs(a[i])) - UINT64_C(0x4085e00000000000);
    }
    if (wmr_every(wmr_mask((inside >> 63) != 0))) {
        for (int i = 0; i < count; ++i) {
            a[i] = wmr_exp_near(a[i]);
        }
    } else {
        for (int i = 0; i < count; ++i) {
            a[i] = wmr_exp_far(a[i]);
        }
    }
}

/* e^x - 1 for |x| < 56; two parts of what is lost when x is reduced are kept. */
static inline wmr_v wmr_expm1_inside(wmr_v x)
{
    const wmr_v shifted = x * WMR_PER_LN2 + WMR_ROUNDER, n = shifted - WMR_ROUNDER;
    const wmr_v high = x - n * WMR_LN2_HIGH, low = n * WMR_LN2_LOW, r = high - low;
    const wmr_v lost = (high - r) - low, power = wmr_power_of_two(shifted);
    const wmr_v sum = (power - 1.0) + power * r;
    const wmr_v rest = power * (wmr_exp_rest(r) + (lost + lost * r));
    return sum + rest;
}

static inline wmr_v wmr_expm1(wmr_v a)
{
    if (wmr_every(wmr_mask(wmr_abs(a) < 0.3465))) { /* of less than half of ln 2 n is 0 */
        return wmr_copysign(a + wmr_exp_rest(a), a);
    }
    const wmr_m inside = wmr_mask(wmr_abs(a) < 56.0);
    wmr_v value = wmr_expm1_inside(wmr_choose(inside, a, wmr_all(0.0)));
    if (!wmr_every(inside)) {
        value = wmr_choose(inside, value, wmr_exp(a) - 1.0);
    }
    return wmr_copysign(value, a);
}

/* ln(2^e (1 + f)) for 1 + f from sqrt(1/2) to sqrt(2); `more` is a small summand. */
static inline wmr_v wmr_log_of(wmr_v e, wmr_v f, wmr_v more)
{
    const wmr_v s = f / (2.0 + f), z = s * s, w = z * z;
    const wmr_v even = w * (3.999999999940941908e-01
                            + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
    const wmr_v odd = z * (6.666666666666735130e-01
                           + w * (2.857142874366239149e-01
                                  + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
    const wmr_v half = 0.5 * f * f, rest = s * (half + (even + odd));
    return e * WMR_LN2_HIGH - ((half - (rest + (e * WMR_LN2_LOW + more))) - f);
}

/* Exponent e and mantissa, from sqrt(1/2) to sqrt(2), of normal positive numbers. */
static inline wmr_v wmr_mantissa(wmr_v x, wmr_v *e)
{
    const wmr_i lifted = wmr_raw(x) - UINT64_C(0x3fe6a09e667f3bcd) + UINT64_C(0x4000000000000000);
    const wmr_i exponent = lifted >> 52; /* e + 1024 */
    *e = wmr_cooked(exponent | UINT64_C(0x4330000000000000)) - (WMR_2P52 + 1024.0);
    return wmr_cooked(wmr_raw(x) - (exponent << 52) + UINT64_C(0x4000000000000000));
}

/* Denormal numbers become normal ones, and `e` what their exponent is too large by. */
static inline wmr_v wmr_lifted(wmr_v a, wmr_v *e)
{
    const wmr_m tiny = wmr_mask(a < DBL_MIN);
    *e = 54.0 * wmr_number(tiny);
    return wmr_choose(tiny, a * WMR_2P54, a);
}

static inline wmr_m wmr_normal(wmr_v a) { return wmr_mask(a >= DBL_MIN) & wmr_mask(a <= DBL_MAX); }

static inline wmr_v wmr_log_near(wmr_v a)
{
    wmr_v e;
    const wmr_v m = wmr_mantissa(a, &e);
    return wmr_log_of(e, m - 1.0, wmr_all(0.0));
}

static inline wmr_v wmr_log_far(wmr_v a)
{
    wmr_v e, tiny;
    const wmr_v m = wmr_mantissa(wmr_lifted(a, &tiny), &e);
    const wmr_v value = wmr_log_of(e - tiny, m - 1.0, wmr_all(0.0));
    const wmr_v other = wmr_choose(wmr_mask(a == 0.0), wmr_all(-WMR_INF),
                                   wmr_choose(wmr_mask(a > 0.0), a, wmr_all(WMR_NAN)));
    return wmr_choose(wmr_mask(a > 0.0) & wmr_mask(a < WMR_INF), value, other);
}

static inline wmr_v wmr_log(wmr_v a)
{
    return wmr_every(wmr_normal(a)) ? wmr_log_near(a) : wmr_log_far(a);
}

/* 1 + a is rounded; what that lost, over 1 + a, is what its logarithm lacks. */
static inline wmr_v wmr_log1p(wmr_v a)
{
    const wmr_v sum = 1.0 + a, lost = wmr_sum_rest(wmr_all(1.0), a, sum) / sum;
    wmr_v e;
    const wmr_v m = wmr_mantissa(sum, &e);
    const wmr_m one = wmr_mask(e == 0.0);
    const wmr_v more = wmr_choose(one, wmr_all(0.0), lost);
    wmr_v value = wmr_log_of(e, wmr_choose(one, a, m - 1.0), more);
    const wmr_m inside = wmr_mask(sum > 0.0) & wmr_mask(sum < WMR_INF);
    if (!wmr_every(inside)) {
        value = wmr_choose(inside, value, wmr_log_far(sum));
    }
    return wmr_choose(wmr_mask(wmr_abs(a) < WMR_2M54), a, value);
}

/* Angles from here on lose digits in the reduction by three parts of pi/2. */
#define WMR_ANGLE_NEAR 1000.0

/* 2/pi times the number of these bits, modulo 4, in units of 2^-190, least significant word first:
   of 2/pi only the 192 bits that decide the two before the point and what follows, in integers
   (M. H. Payne and R. N. Hanek, 1983). */
static inline void wmr_turns(uint64_t bits, uint32_t product[6])
{
    static const uint32_t two_over_pi[39] = {
        0, 0,
        0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab,
        0xdebbc561, 0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e,
        0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4, 0x9c845f8b,
        0xbdf9283b, 0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7,
        0x4f463f66, 0x9e5fea2d, 0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1,
        0x1f8d5d08, 0x56033046,
    };
    const uint64_t m = (bits & UINT64_C(0xfffffffffffff)) | UINT64_C(0x10000000000000);
    const unsigned from = (unsigned)((bits >> 52) & 0x7ff) - 1013u;
    uint32_t window[6];
    uint64_t carry = 0;
    for (unsigned k = 0; k < 6; ++k) {
        const uint32_t *word = two_over_pi + from / 32 + (5 - k);
        window[k] = (uint32_t)((((uint64_t)word[0] << 32) | word[1]) >> (32 - from % 32));
        carry += window[k] * (m & UINT64_C(0xffffffff));
        product[k] = (uint32_t)carry;
        carry >>= 32;
    }
    carry = 0;
    for (unsigned k = 1; k < 6; ++k) {
        carry += window[k - 1] * (m >> 32) + product[k];
        product[k] = (uint32_t)carry;
        carry >>= 32;
    }
}

/* a less the nearest multiple of pi/2, for |a| from WMR_ANGLE_NEAR on. */
WMR_RARE double wmr_reduced_far(double a, unsigned *quarter)
{
    uint64_t bits;
    uint32_t product[6];
    unsigned shift = 0;
    double scale;
    memcpy(&bits, &a, sizeof bits);
    *quarter = 0;
    if (((bits >> 52) & 0x7ff) == 0x7ff) {
        return WMR_NAN;
    }
    wmr_turns(bits, product);
    /* what follows the point, with a sign: nearest, not below */
    uint64_t high = ((uint64_t)product[5] << 34) | ((uint64_t)product[4] << 2) | (product[3] >> 30);
    uint64_t low = ((uint64_t)product[3] << 34) | ((uint64_t)product[2] << 2) | (product[1] >> 30);
    const unsigned above = (unsigned)(high >> 63), turns = (product[5] >> 30) + above;
    *quarter = a < 0.0 ? 0u - turns : turns;
    high = above ? ~high : high;
    low = above ? ~low : low;
    for (; shift < 127 && !(high >> 63); ++shift) {
        high = (high << 1) | (low >> 63);
        low <<= 1;
    }
    bits = (uint64_t)(1023 - 64 - shift) << 52;
    memcpy(&scale, &bits, sizeof scale);
    const double top = (double)(int64_t)(high >> 37) * WMR_2P37; /* 27 bits */
    const double rest = (double)(int64_t)(high & UINT64_C(0x1fffffffff));
    const double less = top * 1.5893254773528196e-08 + rest * 1.57079632679489661923;
    const double r = (top * 1.5707963109016418 + less) * scale;
    return (above != 0) != (a < 0.0) ? -r : r;
}

/* a less the nearest multiple of pi/2; the multiple stands in the low bits of `quarter`. */
static inline wmr_v wmr_reduced(wmr_v a, wmr_i *quarter)
{
    const wmr_v shifted = a * 6.36619772367581382433e-01 + WMR_ROUNDER, n = shifted - WMR_ROUNDER;
    wmr_v r = ((a - n * 1.57079632673412561417e+00) - n * 6.07710050630396597660e-11)
            - n * 2.02226624879595063154e-21;
    *quarter = wmr_raw(shifted);
    if (!wmr_every(wmr_mask(wmr_abs(a) < WMR_ANGLE_NEAR))) {
        for (int i = 0; i < WMR_WIDTH; ++i) {
            const double one = WMR_AT(a, i);
            if (!(fabs(one) < WMR_ANGLE_NEAR)) {
                unsigned turns;
                WMR_AT(r, i) = wmr_reduced_far(one, &turns);
                WMR_AT(*quarter, i) = turns;
            }
        }
    }
    return r;
}

/* sin r and cos r for |r| <= pi/4. */
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

/* The sine of r, `place` quarter turns on. */
static inline wmr_v wmr_turned_sine(wmr_v r, wmr_i place)
{
#if WMR_LANES == 0
    const double size = place & 1 ? wmr_cosine_part(r) : wmr_sine_part(r);
    return place & 2 ? -size : size;
#else
    const wmr_m odd = wmr_mask((place & 1) != 0);
    const wmr_v size = wmr_choose(odd, wmr_cosine_part(r), wmr_sine_part(r));
    return wmr_cooked(wmr_raw(size) ^ ((place & 2) << 62));
#endif
}

/* Below this an angle is its own sine and tangent, and zeros keep their signs. */
#define WMR_ANGLE_TINY WMR_2M27

static inline wmr_v wmr_sin(wmr_v a)
{
    wmr_i quarter;
    const wmr_v r = wmr_reduced(a, &quarter);
    const wmr_v value = wmr_turned_sine(r, quarter);
    return wmr_choose(wmr_mask(wmr_abs(a) < WMR_ANGLE_TINY), a, value);
}

static inline wmr_v wmr_cos(wmr_v a)
{
    wmr_i quarter;
    const wmr_v r = wmr_reduced(a, &quarter);
    return wmr_turned_sine(r, quarter + 1);
}

/* Both at once, of one reduction. */
static inline void wmr_sin_cos(wmr_v a, wmr_v *sine, wmr_v *cosine)
{
    wmr_i quarter;
    const wmr_v r = wmr_reduced(a, &quarter), s = wmr_sine_part(r), c = wmr_cosine_part(r);
    const wmr_m odd = wmr_mask((quarter & 1) != 0);
    const wmr_i sign = wmr_raw(wmr_all(-0.0));
    const wmr_v up = wmr_cooked(wmr_raw(wmr_choose(odd, c, s)) ^ ((quarter << 62) & sign));
    const wmr_v on = wmr_choose(odd, s, c);
    *sine = wmr_choose(wmr_mask(wmr_abs(a) < WMR_ANGLE_TINY), a, up);
    *cosine = wmr_cooked(wmr_raw(on) ^ (((quarter + 1) << 62) & sign));
}

static inline wmr_v wmr_tan(wmr_v a)
{
    wmr_i quarter;
    const wmr_v r = wmr_reduced(a, &quarter);
    const wmr_m odd = wmr_mask((quarter & 1) != 0);
    const wmr_v sine = wmr_sine_part(r), cosine = wmr_cosine_part(r);
    const wmr_v value = wmr_choose(odd, -cosine, sine) / wmr_choose(odd, sine, cosine);
    return wmr_choose(wmr_mask(wmr_abs(a) < WMR_ANGLE_TINY), a, value);
}

/* tanh of sizes below 0.625 is size + size^3 over / under. */
static inline wmr_v wmr_tanh_over(wmr_v z)
{
    return (-9.64399179425052238628e-1 * z - 9.92877231001918586564e1) * z
         - 1.61468768441708447952e3;
}

static inline wmr_v wmr_tanh_under(wmr_v z)
{
    return ((z + 1.12811678491632931402e2) * z + 2.23548839060100448583e3) * z
         + 4.84406305325125486048e3;
}

/* Elsewhere it is 1 - over / under: 1 - 2 / (e^2size + 1) with e^2size = 2^k (q + p) / (q - p). */
static inline wmr_v wmr_tanh_far(wmr_v size, wmr_v *under)
{
    const wmr_v x = 2.0 * size, shifted = x * WMR_PER_LN2 + WMR_ROUNDER, n = shifted - WMR_ROUNDER;
    const wmr_v r = (x - n * WMR_LN2_HIGH) - n * WMR_LN2_LOW, z = r * r;
    const wmr_v p = r * ((1.26177193074810590878e-4 * z + 3.02994407707441961300e-2) * z
                         + 9.99999999999999999910e-1);
    const wmr_v q = ((3.00198505138664455042e-6 * z + 2.52448340349684104192e-3) * z
                     + 2.27265548208155028766e-1) * z + 2.00000000000000000005;
    const wmr_v less = q - p;
    *under = wmr_power_of_two(shifted) * (q + p) + less;
    return 2.0 * less;
}

/* One division: a plant step has four tanh in a chain.  From 19.1 on it is 1. */
static inline wmr_v wmr_tanh(wmr_v a)
{
    const wmr_v size = wmr_abs(a), z = size * size;
#if WMR_LANES == 0
    double under = 1.0;
    if (size > 19.1) {
        return copysign(1.0, a);
    }
    if (size < 0.625) {
        return copysign(size + size * (z * (wmr_tanh_over(z) / wmr_tanh_under(z))), a);
    }
    const double over = wmr_tanh_far(size, &under);
    return copysign(1.0 - over / under, a);
#else
    const wmr_m large = wmr_mask(size > 19.1), slight = wmr_mask(size < 0.625);
    if (wmr_every(large)) {
        return wmr_copysign(wmr_all(1.0), a);
    }
    wmr_v under, over = wmr_tanh_far(wmr_choose(large, wmr_all(20.0), size), &under);
    if (wmr_none(slight)) {
        return wmr_copysign(1.0 - over / under, a);
    }
    over = wmr_choose(slight, wmr_tanh_over(z), over);
    under = wmr_choose(slight, wmr_tanh_under(z), under);
    const wmr_v ratio = over / under;
    return wmr_copysign(wmr_choose(slight, size + size * (z * ratio), 1.0 - ratio), a);
#endif
}

static inline wmr_v wmr_sinh(wmr_v a)
{
    const wmr_v size = wmr_abs(a), t = wmr_expm1(size), share = t / (t + 1.0);
    const wmr_v low = 0.5 * (2.0 * t - t * share), middle = 0.5 * (t + share);
    wmr_v value = wmr_choose(wmr_mask(size < 1.0), low, middle);
    if (wmr_some(wmr_mask(size > 700.0))) {
        value = wmr_choose(wmr_mask(size > 700.0), wmr_exp_over(size, 1.0), value);
    }
    return wmr_copysign(value, a);
}

static inline wmr_v wmr_cosh(wmr_v a)
{
    const wmr_v size = wmr_abs(a), t = wmr_exp(size);
    wmr_v value = 0.5 * t + 0.5 / t;
    if (wmr_some(wmr_mask(size > 700.0))) {
        value = wmr_choose(wmr_mask(size > 700.0), wmr_exp_over(size, 1.0), value);
    }
    return value;
}

/* Around 0, atan 1/2, pi/4, atan 3/2 and pi/2. */
static inline wmr_v wmr_atan(wmr_v a)
{
    const wmr_v t = wmr_abs(a);
    const wmr_m m1 = wmr_mask(t >= 0.4375), m2 = wmr_mask(t >= 0.6875);
    const wmr_m m3 = wmr_mask(t >= 1.1875), m4 = wmr_mask(t >= 2.4375);
    wmr_v over = t, under = wmr_all(1.0), high = wmr_all(0.0), low = wmr_all(0.0);
    over = wmr_choose(m1, 2.0 * t - 1.0, over);
    under = wmr_choose(m1, 2.0 + t, under);
    high = wmr_choose(m1, wmr_all(4.63647609000806093515e-01), high);
    low = wmr_choose(m1, wmr_all(2.26987774529616870924e-17), low);
    over = wmr_choose(m2, t - 1.0, over);
    under = wmr_choose(m2, t + 1.0, under);
    high = wmr_choose(m2, wmr_all(7.85398163397448278999e-01), high);
    low = wmr_choose(m2, wmr_all(3.06161699786838301793e-17), low);
    over = wmr_choose(m3, t - 1.5, over);
    under = wmr_choose(m3, 1.0 + 1.5 * t, under);
    high = wmr_choose(m3, wmr_all(9.82793723247329054082e-01), high);
    low = wmr_choose(m3, wmr_all(1.39033110312309984516e-17), low);
    over = wmr_choose(m4, wmr_all(-1.0), over);
    under = wmr_choose(m4, t, under);
    high = wmr_choose(m4, wmr_all(1.57079632679489655800e+00), high);
    low = wmr_choose(m4, wmr_all(6.12323399573676603587e-17), low);
    const wmr_v x = over / under, z = x * x, w = z * z;
    const wmr_v even = z * (3.33333333333329318027e-01 + w * (1.42857142725034663711e-01
                     + w * (9.09088713343650656196e-02 + w * (6.66107313738753120669e-02
                     + w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
    const wmr_v odd = w * (-1.99999999998764832476e-01 + w * (-1.11111104054623557880e-01
                    + w * (-7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02
                    + w * -3.65315727442169155270e-02))));
    return wmr_copysign(high - ((x * (even + odd) - low) - x), a);
}

static inline wmr_v wmr_atan2(wmr_v y, wmr_v x)
{
    const wmr_v width = wmr_abs(x), height = wmr_abs(y);
    const wmr_v one = wmr_choose(wmr_mask(height == 0.0), height, wmr_all(1.0));
    const wmr_v ratio = wmr_choose(wmr_mask(height == width), one, height / width);
    const wmr_v angle = wmr_atan(ratio);
    const wmr_m back = wmr_mask(wmr_copysign(wmr_all(1.0), x) < 0.0);
    const wmr_v other = 3.14159265358979311600 - (angle - 1.22464679914735320717e-16);
    const wmr_v turned = wmr_choose(back, other, angle);
    const wmr_m steep = wmr_mask(ratio > WMR_2P60);
    return wmr_copysign(wmr_choose(steep, wmr_all(1.57079632679489655800), turned), y);
}

/* (asin x - x) / x for z = x^2, |x| <= 1/2. */
static inline wmr_v wmr_asin_rest(wmr_v z)
{
    const wmr_v over = z * (1.66666666666666657415e-01 + z * (-3.25565818622400915405e-01
                     + z * (2.01212532134862925881e-01 + z * (-4.00555345006794114027e-02
                     + z * (7.91534994289814532176e-04 + z * 3.47933107596021167570e-05)))));
    const wmr_v under = 1.0 + z * (-2.40339491173441421878e+00 + z * (2.02094576023350569471e+00
                      + z * (-6.88283971605453293030e-01 + z * 7.70381505559019352791e-02)));
    return over / under;
}

#define WMR_HALF_PI_HIGH 1.57079632679489655800e+00
#define WMR_HALF_PI_LOW 6.12323399573676603587e-17

/* The square root of z in two parts, the first with half of the digits. */
static inline wmr_v wmr_root_parts(wmr_v z, wmr_v *low)
{
    const wmr_v root = wmr_sqrt(z), high = wmr_high(root), sum = root + high;
    *low = wmr_choose(wmr_mask(z == 0.0), wmr_all(0.0), (z - high * high) / sum);
    return high;
}

/* Above 1/2 by asin x = pi/2 - 2 asin sqrt((1 - x) / 2). */
static inline wmr_v wmr_asin(wmr_v a)
{
    const wmr_v size = wmr_abs(a);
    const wmr_m slight = wmr_mask(size < 0.5);
    const wmr_v z = wmr_choose(slight, size * size, 0.5 * (1.0 - size)), rest = wmr_asin_rest(z);
    wmr_v low;
    const wmr_v high = wmr_root_parts(z, &low), root = high + low;
    const wmr_v lost = 2.0 * root * rest - (WMR_HALF_PI_LOW - 2.0 * low);
    const wmr_v outer = 0.5 * WMR_HALF_PI_HIGH - (lost - (0.5 * WMR_HALF_PI_HIGH - 2.0 * high));
    return wmr_copysign(wmr_choose(slight, size + size * rest, outer), a);
}

static inline wmr_v wmr_acos(wmr_v a)
{
    const wmr_v size = wmr_abs(a);
    const wmr_m slight = wmr_mask(size < 0.5);
    const wmr_v z = wmr_choose(slight, size * size, 0.5 * (1.0 - size)), rest = wmr_asin_rest(z);
    wmr_v low;
    const wmr_v high = wmr_root_parts(z, &low), root = high + low;
    const wmr_v central = WMR_HALF_PI_HIGH - (a - (WMR_HALF_PI_LOW - a * rest));
    const wmr_v forward = 2.0 * (high + (rest * root + low));
    const wmr_v back = 2.0 * (WMR_HALF_PI_HIGH - (root + (rest * root - WMR_HALF_PI_LOW)));
    return wmr_choose(slight, central, wmr_choose(wmr_mask(a < 0.0), back, forward));
}

/* Scaled by a power of two where squares would be beyond what numbers can be. */
static inline wmr_v wmr_hypot(wmr_v a, wmr_v b)
{
    const wmr_v x = wmr_abs(a), y = wmr_abs(b);
    const wmr_m huge = wmr_mask(x > WMR_2P500) | wmr_mask(y > WMR_2P500);
    const wmr_m tiny = wmr_mask(x < WMR_2M450) & wmr_mask(y < WMR_2M450);
    const wmr_v one = wmr_all(1.0), large = wmr_all(WMR_2P600), little = wmr_all(WMR_2M600);
    const wmr_v down = wmr_choose(huge, little, wmr_choose(tiny, large, one));
    const wmr_v up = wmr_choose(huge, large, wmr_choose(tiny, little, one));
    const wmr_v u = x * down, v = y * down, value = wmr_sqrt(u * u + v * v) * up;
    const wmr_m endless = wmr_mask(x == WMR_INF) | wmr_mask(y == WMR_INF);
    return wmr_choose(endless, wmr_all(WMR_INF), value);
}

/* ln a of positive numbers in two parts, together right to some 2^-66:
   2/3 s (3 + s^2 + 3/5 s^4 + ...). */
static inline wmr_v wmr_log_parts(wmr_v a, wmr_v *low)
{
    wmr_v e, tiny;
    const wmr_v m = wmr_mantissa(wmr_lifted(a, &tiny), &e), f = m - 1.0;
    const wmr_v n = e - tiny, d = 2.0 + f, d_low = f - (d - 2.0);
    const wmr_v s = f / d, s_product = s * d;
    const wmr_v s_low = ((f - s_product) - (wmr_product_rest(s, d, s_product) + s * d_low)) / d;
    const wmr_v z = s * s, z_low = wmr_product_rest(s, s, z) + 2.0 * s * s_low;
    const wmr_v tail = z * z * (6.0 / 10.0 + z * (6.0 / 14.0 + z * (6.0 / 18.0 + z * (6.0 / 22.0
                     + z * (6.0 / 26.0 + z * (6.0 / 30.0 + z * (6.0 / 34.0 + z * (6.0 / 38.0
                     + z * (6.0 / 42.0 + z * (6.0 / 46.0 + z * (6.0 / 50.0)))))))))));
    const wmr_v q = 3.0 + z, q_low = (z - (q - 3.0)) + (z_low + tail);
    const wmr_v p = s * q, p_low = wmr_product_rest(s, q, p) + (s * q_low + s_low * q);
    const wmr_v third = wmr_all(2.0 / 3.0), third_low = wmr_all(3.70074341541718833e-17);
    const wmr_v g = p * third;
    const wmr_v g_low = wmr_product_rest(p, third, g) + (p * third_low + p_low * third);
    const wmr_v base = n * WMR_LN2_HIGH, sum = base + g;
    const wmr_v rest = wmr_sum_rest(base, g, sum) + (g_low + n * WMR_LN2_LOW);
    const wmr_v high = sum + rest;
    *low = rest - (high - sum);
    return high;
}

/* |a|^b as e^(b ln |a|), the exponent in two parts. */
static inline wmr_v wmr_power_of_size(wmr_v size, wmr_v b)
{
    wmr_v low;
    const wmr_m inside = wmr_mask(size > 0.0) & wmr_mask(size < WMR_INF);
    const wmr_v parts = wmr_log_parts(wmr_choose(inside, size, wmr_all(1.0)), &low);
    const wmr_v high = wmr_choose(inside, parts, wmr_log_far(size));
    const wmr_v p = b * high, p_low = wmr_product_rest(b, high, p) + b * low;
    const wmr_v value = wmr_exp(p), better = value + value * p_low;
    return wmr_choose(wmr_mask(wmr_abs(p) < 1000.0) & wmr_finite(value), better, value);
}

static inline wmr_v wmr_pow(wmr_v a, wmr_v b)
{
    const wmr_v size = wmr_abs(a), half = 0.5 * b;
    const wmr_m whole = wmr_mask(wmr_floor(b) == b);
    const wmr_m odd = whole & wmr_mask(wmr_abs(b) < WMR_2P53) & wmr_mask(wmr_floor(half) != half);
    const wmr_m one = wmr_mask(b == 0.0) | wmr_mask(a == 1.0)
                    | (wmr_mask(a == -1.0) & wmr_mask(wmr_abs(b) == WMR_INF));
    const wmr_m refused = wmr_mask(a < 0.0) & wmr_finite(a) & wmr_not(whole) & wmr_mask(b == b);
    const wmr_v value = wmr_power_of_size(size, b);
    const wmr_v turned = wmr_choose(odd, wmr_copysign(value, a), value);
    return wmr_choose(one, wmr_all(1.0), wmr_choose(refused, wmr_all(WMR_NAN), turned));
}

#endif
