/* Sampled models: evaluated at the start of each of their periods with the inputs of that moment,
   held until the next.  Before the first step, outputs are those of sample 0 with the inputs so
   far, and no memory moves.  With clock.parallel = 1 sample 0 keeps the inputs of initialisation.
   A model without inputs has its values at the time that was reached. */
#include <math.h>
#include <string.h>

#include "instance.h"

#define PERIOD_TOLERANCE 1e-6

int kind_start(struct wmr_instance *s)
{
    s->state.memory.count = 0;
    memcpy(s->state.memory.first, s->state.values + WMR_U, WMR_NU * sizeof(double));
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

/* Whether sample 0 is to keep the inputs of initialisation. */
static int keeps_first(const struct wmr_instance *s)
{
#ifdef WMR_AT_PARALLEL
    return s->state.memory.count == 0 && s->state.values[WMR_AT_PARALLEL] > 0.5;
#else
    (void)s;
    return 0;
#endif
}

/* Outputs and diagnostics from inputs, memory and parameters; `next` takes the next memory. */
static void evaluate(struct wmr_instance *s, const double *inputs, double *next)
{
    double *v = s->state.values, *w = v + WMR_W;
    wmr_evaluate(inputs, v + WMR_X, v + WMR_P, next, w, w + WMR_NY);
}

static void sample(struct wmr_instance *s, double t)
{
    double *values = s->state.values, next[WMR_NX + 1];
    values[0] = t;
    evaluate(s, keeps_first(s) ? s->state.memory.first : values + WMR_U, next);
    memcpy(s->state.memory.used, values + WMR_X, WMR_NX * sizeof(double));
    memcpy(values + WMR_X, next, WMR_NX * sizeof(double));
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

/* The time that was reached; rounded to the grid of samples if only rounding separates them. */
static double reached(const struct wmr_instance *s)
{
    const double t = s->state.values[0], period = s->state.values[WMR_AT_PERIOD];
    const double near = s->state.start_time + rint((t - s->state.start_time) / period) * period;
    return fabs(t - near) <= PERIOD_TOLERANCE * period ? near : t;
}

void kind_refresh(struct wmr_instance *s)
{
    double next[WMR_NX + 1];
    if (WMR_NU == 0 && s->state.interface == WMR_CO_SIMULATION) {
        const double t = reached(s);
        evaluate(s, &t, next);
    } else if (s->state.memory.count == 0) {
        evaluate(s, s->state.values + WMR_U, next);
    }
}
