/* The filter's step in the form that drive.c calls, and the clip that one would write by hand. */
#include "wmr_filter.h"

#include <math.h>

static wmr_filter_parameters parameters;

long filter_size(void)
{
    return (long)(sizeof(wmr_filter_state) / sizeof(double));
}

void filter_begin(double *state)
{
    wmr_filter_defaults(&parameters);
    wmr_filter_start((wmr_filter_state *)state);
}

void filter_step(const double *in, double *state, double *out)
{
    wmr_filter_step(&parameters, (wmr_filter_state *)state, (const wmr_filter_inputs *)in,
                    (wmr_filter_outputs *)out);
}

/* Each axis at its limit, what is no number as 0: no state, no promise. */
void hand_step(const double *in, double *state, double *out)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        const double most = parameters.limits_v_u1[i], asked = isfinite(in[i]) ? in[i] : 0.0;
        out[i] = asked > most ? most : asked < -most ? -most : asked;
    }
}
