/* The filter's step for many bases, each with memory of its own. */
#include "wmr_filter.h"

void wmr_filter_many(long count, long inputs, long state, long outputs, const double *parameters,
                     double *x, const double *u, double *y)
{
    for (long i = 0; i < count; ++i)
        wmr_filter_step((const wmr_filter_parameters *)parameters, (wmr_filter_state *)(x + i * state),
                        (const wmr_filter_inputs *)(u + i * inputs),
                        (wmr_filter_outputs *)(y + i * outputs));
}
