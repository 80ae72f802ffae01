/* Choice of vector instructions at run time: the best compiled set that this processor has and this
   operating system saves. */
#include <stdint.h>

#include "export.h"

#define WMR_DECLARE(set)                                                          \
    int32_t wmr_run_set_##set(const void *settings, void *findings, void *state); \
    void wmr_set_sizes_##set(int64_t sizes[7]);

WMR_DECLARE(baseline)

#if defined(WMR_HAS_avx2) || defined(WMR_HAS_avx512)
#include <cpuid.h>

/* Bits of cpuid that x86-64-v3 and v4 require: leaf 1 ECX, leaf 7 EBX, leaf 0x80000001 ECX. */
#define V3_FIRST 0x38D83201u   /* SSE3, SSSE3, FMA, CX16, SSE4.1, SSE4.2, MOVBE, POPCNT, OSXSAVE, AVX, F16C */
#define V3_SEVENTH 0x00000128u /* BMI1, AVX2, BMI2 */
#define V3_EXTENDED 0x00000021u /* LAHF, LZCNT */
#define V4_SEVENTH 0xD0030000u /* AVX512F, DQ, CD, BW, VL */
#define SAVES_YMM 0x06u
#define SAVES_ZMM 0xE6u

static uint32_t saved_registers(void)
{
    uint32_t low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

static int has_all(uint32_t found, uint32_t wanted)
{
    return (found & wanted) == wanted;
}

/* 4, 3 or 0: which x86-64 level may be used. */
static int level(void)
{
    unsigned int a, b, first, seventh, extended, d;
    if (!__get_cpuid(1, &a, &b, &first, &d) || !has_all(first, V3_FIRST)
        || !__get_cpuid_count(7, 0, &a, &seventh, &b, &d) || !has_all(seventh, V3_SEVENTH)
        || !__get_cpuid(0x80000001u, &a, &b, &extended, &d) || !has_all(extended, V3_EXTENDED)
        || !has_all(saved_registers(), SAVES_YMM)) {
        return 0;
    }
    return has_all(seventh, V4_SEVENTH) && has_all(saved_registers(), SAVES_ZMM) ? 4 : 3;
}
#else
static int level(void)
{
    return 0;
}
#endif

#ifdef WMR_HAS_avx2
WMR_DECLARE(avx2)
#endif
#ifdef WMR_HAS_avx512
WMR_DECLARE(avx512)
#endif

typedef struct {
    const char *name;
    int level; /* level of x86-64 that it needs */
    int32_t (*run)(const void *settings, void *findings, void *state);
    void (*sizes)(int64_t sizes[7]);
} vector_set;

/* Best first. */
static const vector_set SETS[] = {
#ifdef WMR_HAS_avx512
    {"avx512", 4, wmr_run_set_avx512, wmr_set_sizes_avx512},
#endif
#ifdef WMR_HAS_avx2
    {"avx2", 3, wmr_run_set_avx2, wmr_set_sizes_avx2},
#endif
    {"baseline", 0, wmr_run_set_baseline, wmr_set_sizes_baseline},
};

/* The k-th of the sets that can run here, or NULL. */
static const vector_set *usable(int32_t k)
{
    const int most = level();
    for (int i = 0; i < (int)(sizeof SETS / sizeof SETS[0]); ++i) {
        if (SETS[i].level <= most && k-- == 0) {
            return SETS + i;
        }
    }
    return 0;
}

/* Name of the k-th set that can run here, best first; NULL after the last. */
WMR_EXPORT const char *wmr_set_name(int32_t k)
{
    const vector_set *set = usable(k);
    return set ? set->name : 0;
}

/* Sizes that library.c reports for the k-th set, by which the caller arranges its memory. */
WMR_EXPORT void wmr_sizes(int32_t k, int64_t sizes[7])
{
    usable(k)->sizes(sizes);
}

/* Runs all lanes to the end with the k-th set; 0, or 1 if it was cancelled. */
WMR_EXPORT int32_t wmr_run(int32_t k, const void *settings, void *findings, void *state)
{
    return usable(k)->run(settings, findings, state);
}
