/* The loop of one robot for a page that is its own master: it takes one control sample at a time, may
   change parameters, state and clock between two of them, and may hand a run over to another loop.
   WMR_SET names the loop, since a module holds several; WMR_PHASES_MOST and WMR_DELAY_MOST bound how
   many rows of parameters and plant steps of delay there is room for.  All memory is the caller's. */
#define WMR_KERNEL static
#define WMR_LANES 0

#define WMR_JOIN_(a, b) a##_##b
#define WMR_JOIN(a, b) WMR_JOIN_(a, b)
#define WMR_OWN(name) WMR_JOIN(name, WMR_SET)
#define WMR_PAGE(name) __attribute__((export_name(WMR_TEXT(WMR_OWN(name))))) WMR_OWN(name)
#define WMR_TEXT_(a) #a
#define WMR_TEXT(a) WMR_TEXT_(a)

#define wmr_philox WMR_OWN(wmr_philox)
#define wmr_loop_start WMR_OWN(wmr_loop_start)
#define wmr_loop_sample WMR_OWN(wmr_loop_sample)
#define wmr_loop_run WMR_OWN(wmr_loop_run)
#define wmr_seed_key WMR_OWN(wmr_seed_key)

#include <stddef.h>

#include "kernels.c"
#include "noise.c"
#include "loop.c"
#include "seed.c"

/* Numbers that the page writes and reads come first, in 8 bytes each; see WMR_PAGE(places). */
typedef struct {
    double row[WMR_ROW], start[WMR_STATE], parameters[WMR_PHASES_MOST * WMR_PARAMETERS];
    int64_t phase_start[WMR_PHASES_MOST];
    double queue[2 * WMR_DELAY_MOST + 2];
    uint64_t key[2];
    int32_t cancelled;
    wmr_settings settings;
    wmr_loop loop;
} robot;

/* Bytes of a robot, then where it has row, start, parameters, first steps of the phases, findings. */
void WMR_PAGE(places)(int32_t at[6])
{
    const size_t places[6] = {sizeof(robot), offsetof(robot, row), offsetof(robot, start),
                              offsetof(robot, parameters), offsetof(robot, phase_start),
                              offsetof(robot, loop) + offsetof(wmr_loop, findings)};
    for (int i = 0; i < 6; ++i) {
        at[i] = (int32_t)places[i];
    }
}

/* Begins a run from `start` with `phases` rows of parameters; 0 if it ends before its first step. */
int32_t WMR_PAGE(begin)(robot *r, int32_t phases, double seed)
{
    wmr_seed_key((uint64_t)seed, r->key);
    r->cancelled = 0;
    memset(&r->settings, 0, sizeof r->settings);
    r->settings.samples = INT64_MAX;
    r->settings.phases = phases;
    r->settings.phase_start = r->phase_start;
    r->settings.key = r->key;
    r->settings.cancelled = &r->cancelled;
    r->settings.parameters = r->parameters;
    r->settings.start = r->start;
    r->settings.queue = r->queue;
    wmr_loop_start(&r->settings, &r->loop);
    return r->loop.running != 0 && r->loop.delay_steps <= WMR_DELAY_MOST;
}

/* One control sample, whose line of the log is in `row` then; 0 if the run has ended. */
int32_t WMR_PAGE(sample)(robot *r)
{
    wmr_loop_sample(&r->settings, &r->loop, r->row);
    return r->loop.running != 0;
}

/* Address of the valid state. */
double *WMR_PAGE(state)(robot *r) { return wmr_loop_state(&r->loop); }

/* Puts changed parameters into force. */
void WMR_PAGE(changed)(robot *r)
{
    wmr_clock(parameters(&r->settings, &r->loop), r->loop.clock);
    prepare(&r->settings, &r->loop);
}

/* Goes on at a sample, as the successor of a run that came so far; the state is written separately. */
void WMR_PAGE(resume)(robot *r, double sample)
{
    r->loop.sample = (int64_t)sample;
    r->loop.step = r->loop.sample * r->loop.substeps;
    change(&r->settings, &r->loop);
}
