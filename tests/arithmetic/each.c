/* Every function of arithmetic.h on arrays, and a hash of what each makes of inputs that are drawn
   here, from integers alone: equal hashes, equal bits.  Without stdio unless WMR_PRINT is defined. */
#include "arithmetic.h"

static inline wmr_v wmr_sin_of_both(wmr_v a)
{
    wmr_v sine, cosine;
    wmr_sin_cos(a, &sine, &cosine);
    return sine;
}

static inline wmr_v wmr_cos_of_both(wmr_v a)
{
    wmr_v sine, cosine;
    wmr_sin_cos(a, &sine, &cosine);
    return cosine;
}

#if defined(_WIN32)
#define SHOWN __declspec(dllexport)
#else
#define SHOWN __attribute__((visibility("default")))
#endif

#define ONES(X) X(exp) X(expm1) X(log) X(log1p) X(sin) X(cos) X(tan) X(tanh) X(sinh) X(cosh) \
    X(asin) X(acos) X(atan) X(sqrt) X(floor) X(ceil) X(abs) X(sign) X(one_nan) \
    X(sin_of_both) X(cos_of_both)
#define PAIRS(X) X(atan2) X(hypot) X(pow) X(min) X(max) X(copysign)

/* The lanes of `a` are overwritten; `count` is a multiple of 8. */
#define WALK(name, made)                                              \
    SHOWN void each_##name(double *a, const double *b, int64_t count) \
    {                                                                 \
        for (int64_t i = 0; i < count; i += WMR_WIDTH) {              \
            wmr_v v, w;                                               \
            memcpy(&v, a + i, sizeof v);                              \
            memcpy(&w, b + i, sizeof w);                              \
            (void)w;                                                  \
            v = made;                                                 \
            memcpy(a + i, &v, sizeof v);                              \
        }                                                             \
    }
#define WALK_ONE(name) WALK(name, wmr_##name(v))
#define WALK_PAIR(name) WALK(name, wmr_##name(v, w))
ONES(WALK_ONE)
PAIRS(WALK_PAIR)

SHOWN void each_exp_many(double *a, const double *b, int64_t count)
{
    (void)b;
    for (int64_t i = 0; i < count; i += 8) {
        wmr_v v[8 / WMR_WIDTH];
        memcpy(v, a + i, sizeof v);
        wmr_exp_many(v, 8 / WMR_WIDTH);
        memcpy(a + i, v, sizeof v);
    }
}

typedef void walk(double *a, const double *b, int64_t count);
#define LISTED(name) each_##name,
static walk *const WALKS[] = {ONES(LISTED) PAIRS(LISTED) each_exp_many};

#define DRAWS 4096
static double given[DRAWS], other[DRAWS];

static uint64_t drawn(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    return *state ^= *state << 17;
}

static double number(uint64_t bits)
{
    double a;
    memcpy(&a, &bits, sizeof a);
    return a;
}

/* Kinds in turn: any bits at all, [-1, 1), [-16, 16), [-1024, 1024), whole or half, next to them. */
static double input(uint64_t *state)
{
    static const double sizes[] = {0.0, 1.0, 16.0, 1024.0};
    const uint64_t bits = drawn(state), kind = drawn(state) % 6;
    const double unit = (double)((int64_t)bits >> 11) * 0x1p-52, half = (double)(int64_t)(bits & 2047) * 0.5 - 512.0;
    if (kind == 0) {
        return number(bits);
    }
    return kind < 4 ? unit * sizes[kind] : half + (kind == 5 ? unit * 0x1p-40 : 0.0);
}

/* Hash of the bits that function `which` makes, every NaN as one; 0 beyond the last function. */
SHOWN uint64_t hash_of(int32_t which)
{
    static const uint64_t special[] = {
        0, 1, 0x000fffffffffffff, 0x0010000000000000, 0x3fe0000000000000, 0x3ff0000000000000,
        0x4000000000000000, 0x433fffffffffffff, 0x7fefffffffffffff, 0x7ff0000000000000, 0x7ff8000000000000,
    };
    const int count = (int)(sizeof special / sizeof *special);
    uint64_t state = UINT64_C(0x9E3779B97F4A7C15), hash = 1;
    if (which < 0 || which >= (int32_t)(sizeof WALKS / sizeof *WALKS)) {
        return 0;
    }
    for (int i = 0; i < DRAWS; ++i) {
        const uint64_t sign = (uint64_t)(i & 1) << 63, turned = (uint64_t)(i / 2 & 1) << 63;
        const int place = i / 4;
        given[i] = place < count * count ? number(special[place / count] | sign) : input(&state);
        other[i] = place < count * count ? number(special[place % count] | turned) : input(&state);
    }
    WALKS[which](given, other, DRAWS);
    each_one_nan(given, given, DRAWS);
    for (int i = 0; i < DRAWS; ++i) {
        uint64_t bits;
        memcpy(&bits, &given[i], sizeof bits);
        hash = (hash ^ bits) * UINT64_C(0x9E3779B97F4A7C15);
        hash ^= hash >> 31; /* products carry bits up only */
    }
    return hash;
}

/* The most lanes that this processor has registers for; called in a library for any processor. */
SHOWN int32_t most_lanes(void)
{
#if defined(__x86_64__) && defined(__GNUC__) && !defined(_WIN32) && !defined(WMR_PRINT)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")
        && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd")) {
        return 8;
    }
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? 4 : 2;
#else
    return 2;
#endif
}

#if defined(WMR_PRINT)
#include <inttypes.h>
#include <stdio.h>

int main(void)
{
    uint64_t hash;
    for (int32_t which = 0; (hash = hash_of(which)) != 0; ++which) {
        printf("%016" PRIx64 "\n", hash);
    }
    return 0;
}
#endif
