/* One translation unit for the native engine: kernels and loop together, so that the compiler
   may inline the one into the other; only what is marked WMR_EXPORT leaves the library. */
#define WMR_KERNEL static

#if defined(__AVX__)
#include <immintrin.h>
#endif

#include "export.h"
#include "kernels.c"
#include "noise.c"
#include "loop.c"

#include "exports.h"

/* Leaves the upper halves of vector registers clean: gcc 12 forgets to, and code of the baseline
   that runs afterwards then takes up to twice as long. */
static void tidy(void)
{
#if defined(__AVX__)
    _mm256_zeroupper();
#endif
}

WMR_EXPORT int64_t wmr_run(const wmr_settings *s, wmr_loop *w, double *log)
{
    const int64_t rows = wmr_loop_run(s, w, log);
    tidy();
    return rows;
}

WMR_EXPORT void wmr_start(const wmr_settings *s, wmr_loop *w)
{
    wmr_loop_start(s, w);
}

WMR_EXPORT void wmr_sample(const wmr_settings *s, wmr_loop *w, double *row)
{
    wmr_loop_sample(s, w, row);
    tidy();
}

/* One sample of the law in place, for callers that keep one pointer. */
typedef struct {
    const double *u, *p;
    double *x, *y;
} wmr_call;

WMR_EXPORT void wmr_law_step(const wmr_call *c)
{
    double next[WMR_CONTROLLER_NX + 1];
    wmr_controller_step(c->u, c->x, c->p, next, c->y);
    copy(c->x, next, WMR_CONTROLLER_NX);
}

/* Sizes of the structs above, for the check that both sides of the seam agree. */
WMR_EXPORT int64_t wmr_size_of_settings(void)
{
    return (int64_t)sizeof(wmr_settings);
}

WMR_EXPORT int64_t wmr_size_of_loop(void)
{
    return (int64_t)sizeof(wmr_loop);
}

WMR_EXPORT void wmr_noise_block(const uint64_t *counter, const uint64_t *key, uint64_t *out)
{
    wmr_philox(counter, key, out);
}
