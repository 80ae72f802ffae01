/* Continuous models: rates for the importer's solver, and the fixed-step Runge-Kutta solver of the
   native loop for co-simulation. */
#include <math.h>
#include <string.h>

#include "instance.h"

int kind_start(struct wmr_instance *s)
{
    (void)s;
    return 1;
}

void kind_restore(struct wmr_instance *s)
{
    (void)s;
}

/* Whole steps in h, and what is left; a remainder that is rounding does not count. */
static double whole_steps(double h, double step, double *rest)
{
    const double near = floor(h / step + 0.5);
    if (near >= 1.0 && fabs(h - near * step) <= 1e-9 * h) {
        *rest = 0.0;
        return near;
    }
    *rest = fmod(h, step);
    return floor(h / step);
}

double kind_steps(const struct wmr_instance *s, double t, double h)
{
    (void)t;
    return h / s->state.values[WMR_AT_STEP];
}

static void runge_kutta(struct wmr_instance *s, const double *parameters)
{
    double *x = s->state.values + WMR_X, next[WMR_NX];
    wmr_rk4(s->state.values + WMR_U, x, parameters, next);
    memcpy(x, next, sizeof next);
}

double kind_advance(struct wmr_instance *s, double t, double h)
{
    double parameters[WMR_NP], rest;
    const double *values = s->state.values;
    const double step = values[WMR_AT_STEP], count = whole_steps(h, step, &rest);
    memcpy(parameters, values + WMR_P, sizeof parameters);
    for (double i = 1.0; i <= count; i += 1.0) {
        runge_kutta(s, parameters);
        if (s->pause && (i < count || rest > 0.0) && s->pause(s, t + i * step)) {
            return t + i * step;
        }
    }
    if (rest > 0.0) {
        parameters[WMR_AT_STEP - WMR_P] = rest;
        runge_kutta(s, parameters);
    }
    return t + h;
}

void kind_refresh(struct wmr_instance *s)
{
    double *v = s->state.values, *w = v + WMR_W;
    wmr_evaluate(v + WMR_U, v + WMR_X, v + WMR_P, w, w + WMR_NX, w + WMR_NX + WMR_NY);
}
