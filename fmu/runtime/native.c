/* The loop for one robot, with the same entries as dispatch.c has for vectors of them; and, for
   callers that take one kernel at a time, the kernels themselves. */
#define WMR_SET native
#define WMR_LANES 0

#include "library.c"

#include "exports.h"

WMR_EXPORT const char *wmr_set_name(int32_t k)
{
    return k == 0 ? "native" : 0;
}

WMR_EXPORT void wmr_sizes(int32_t k, int64_t sizes[7])
{
    (void)k;
    wmr_set_sizes_native(sizes);
}

WMR_EXPORT int32_t wmr_run(int32_t k, const void *settings, void *findings, void *state)
{
    (void)k;
    return wmr_run_set_native(settings, findings, state);
}

/* One sample of the law in place, for callers that keep one pointer. */
typedef struct {
    const double *u, *p;
    double *x, *y;
    double largest; /* what no input may exceed in size */
} wmr_call;

/* What is no number is not within anything. */
static int all_within(const double *values, int count, double most)
{
    for (int i = 0; i < count; i++) {
        if (!(values[i] >= -most && values[i] <= most)) {
            return 0;
        }
    }
    return 1;
}

/* 1 if an input is too large, or a result is none: torques 0, the memory as it was. */
WMR_EXPORT int32_t wmr_law_step(const wmr_call *c)
{
    double next[WMR_CONTROLLER_NX + 1];
    if (all_within(c->u, WMR_CONTROLLER_NU, c->largest)) {
        wmr_controller(c->u, c->x, c->p, next, c->y);
        if (all_within(c->y, 2, DBL_MAX) && all_within(next, WMR_CONTROLLER_NX, DBL_MAX)) {
            copy(c->x, next, WMR_CONTROLLER_NX);
            return 0;
        }
    }
    c->y[0] = c->y[1] = 0.0;
    return 1;
}

WMR_EXPORT void wmr_noise_block(const uint64_t *counter, const uint64_t *key, uint64_t *out)
{
    wmr_philox(counter, key, out);
}
