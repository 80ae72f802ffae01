/* Sampled models: evaluated at the start of each of their periods with the inputs of that moment,
   held until the next.  Before the first step, outputs are those of sample 0 with the inputs so
   far, and no memory moves.  A model without memory whose only input is time follows the time
   instead where the importer integrates. */
#include <math.h>
#include <string.h>

#include "instance.h"

#define PERIOD_TOLERANCE 1e-6

int kind_start(struct wmr_instance *s)
{
    s->state.memory.count = 0;
    return 1;
}

void kind_restore(struct wmr_instance *s)
{
    (void)s;
}

double kind_steps(const struct wmr_instance *s, double t, double h)
{
    (void)t;
    return h / s->state.values[WMR_AT_PERIOD];
}

static double sample_time(const struct wmr_instance *s)
{
    return s->state.start_time + (double)s->state.memory.count * s->state.values[WMR_AT_PERIOD];
}

/* Results from known values; what follows the next memory are outputs and diagnostics. */
static void evaluate(struct wmr_instance *s, const double *known)
{
    wmr_evaluate(known, s->scratch.found);
    memcpy(s->state.values + WMR_W, s->scratch.found + WMR_NX, WMR_NW * sizeof(double));
}

static void sample(struct wmr_instance *s, double t)
{
    double *values = s->state.values;
    values[0] = t;
    memcpy(s->state.memory.used, values + WMR_X, WMR_NX * sizeof(double));
    evaluate(s, values + WMR_Z);
    memcpy(values + WMR_X, s->scratch.found, WMR_NX * sizeof(double));
    s->state.memory.count += 1;
}

double kind_advance(struct wmr_instance *s, double t, double h)
{
    const double slack = PERIOD_TOLERANCE * s->state.values[WMR_AT_PERIOD], end = t + h;
    while (sample_time(s) < end - slack) {
        sample(s, sample_time(s));
        const double next = sample_time(s);
        if (s->pause && next < end - slack && s->pause(s, next)) {
            return next;
        }
    }
    return end;
}

void kind_refresh(struct wmr_instance *s)
{
    if (s->state.memory.count == 0) {
        evaluate(s, s->state.values + WMR_Z);
    }
}
