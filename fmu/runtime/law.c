/* The controller by itself, for callers of single samples. */
#define WMR_KERNEL static
#define WMR_LANES 0

#include <float.h>
#include <stdint.h>
#include <string.h>

#include "export.h"
#include "kernels.c"

#include "exports.h"

/* One sample of the law in place, for callers that keep one pointer. */
typedef struct {
    const double *u, *p;
    double *x, *y;
    double largest; /* largest size of an input */
} wmr_call;

/* False for NaN. */
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
            memcpy(c->x, next, WMR_CONTROLLER_NX * sizeof(double));
            return 0;
        }
    }
    c->y[0] = c->y[1] = 0.0;
    return 1;
}
