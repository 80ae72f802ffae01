/* The filter's step for many bases, each with memory of its own. */
#include "wmr_filter.h"

void wmr_filter_many(long count, long inputs, long outputs, void *memories, const wmr_real *u, wmr_real *y)
{
    wmr_filter_parameters p;
    wmr_filter_state *x = memories;
    wmr_filter_defaults(&p);
    for (long i = 0; i < count; ++i)
        wmr_filter_step(&p, x + i, (const wmr_filter_inputs *)(u + i * inputs),
                        (wmr_filter_outputs *)(y + i * outputs));
}

/* Memories at the first sample; their size in numbers with none of them. */
long wmr_filter_begin(long count, void *memories)
{
    wmr_filter_state *x = memories;
    for (long i = 0; i < count; ++i) wmr_filter_start(x + i);
    return (long)(sizeof *x / sizeof(wmr_real));
}
