/* One translation unit for one way to run the loop: kernels and loop together, so that the compiler
   may inline the one into the other.  WMR_SET names the way, WMR_LANES is its width; several of
   them may stand in one library, each under names of its own (see dispatch.c; native.c has one alone). */
#define WMR_KERNEL static

#define WMR_JOIN_(a, b) a##_##b
#define WMR_JOIN(a, b) WMR_JOIN_(a, b)
#define WMR_OWN(name) WMR_JOIN(name, WMR_SET)

#define wmr_philox WMR_OWN(wmr_philox)
#define wmr_loop_start WMR_OWN(wmr_loop_start)
#define wmr_loop_sample WMR_OWN(wmr_loop_sample)
#define wmr_loop_run WMR_OWN(wmr_loop_run)

#include "export.h"
#include "kernels.c"
#include "noise.c"
#include "loop.c"

/* Leaves the upper halves of vector registers clean: gcc 12 forgets to, and code of the baseline
   that runs afterwards then takes up to twice as long.  The builtin of gcc and clang, since the header
   that names it takes longer to read than all the rest. */
static void tidy(void)
{
#if defined(__AVX__) && defined(__GNUC__)
    __builtin_ia32_vzeroupper();
#endif
}

/* Runs all lanes to the end; `findings` (WMR_FINDINGS) and `state` (WMR_STATE) may not be NULL. */
int32_t WMR_OWN(wmr_run_set)(const void *settings, void *findings, void *state)
{
    wmr_loop w;
    const int cancelled = wmr_loop_run(settings, &w);
    memcpy(findings, w.findings, sizeof w.findings);
    memcpy(state, wmr_loop_state(&w), WMR_STATE * sizeof(wmr_v));
    tidy();
    return cancelled;
}

/* Lanes, bytes of the settings, findings, sums (0: every run must have a log), columns, numbers of the
   state and parameters. */
void WMR_OWN(wmr_set_sizes)(int64_t sizes[7])
{
    sizes[0] = WMR_WIDTH;
    sizes[1] = (int64_t)sizeof(wmr_settings);
    sizes[2] = WMR_FINDINGS;
#ifdef WMR_SAMPLE_WATCHED_PREPARED
    sizes[3] = WMR_WINDOW;
#else
    sizes[3] = 0;
#endif
    sizes[4] = WMR_ROW;
    sizes[5] = WMR_STATE;
    sizes[6] = WMR_PARAMETERS;
}
