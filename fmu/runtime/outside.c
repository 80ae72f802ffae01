/* The loop without reference, controller and plant, for those that are coupled from outside: sensors,
   disturbances, drives, the queue of commands, random numbers and the monitor are those of loop.c.
   The state has the loop's layout; what belongs to the parts outside stays at rest in it. */
#define WMR_KERNEL static
#define WMR_LANES 0
#define WMR_OUTSIDE

#include "export.h"
#include "kernels.c"
#include "noise.c"
#include "loop.c"

/* Bytes of the settings and of the loop, and numbers of a measurement and of what acts. */
WMR_EXPORT void wmr_outside_sizes(int64_t sizes[4])
{
    sizes[0] = (int64_t)sizeof(wmr_settings);
    sizes[1] = (int64_t)sizeof(wmr_loop);
    sizes[2] = WMR_MEASURED;
    sizes[3] = WMR_ACTING;
}

/* 0 if the run ends before its first step. */
WMR_EXPORT int32_t wmr_outside_start(const wmr_settings *s, wmr_loop *w)
{
    wmr_loop_start(s, w);
    return w->running;
}

/* One control sample: what the sensors show of a plant's state, and what disturbs it. */
WMR_EXPORT void wmr_outside_sample(const wmr_settings *s, wmr_loop *w, const double *plant, double *out)
{
    double next[WMR_STATE - WMR_FAST + 1], draws[WMR_SAMPLE_DRAWS + 1];
    const double k = (double)w->sample;
    copy(w->state, plant, WMR_PLANT);
    change(s, w);
    draw(s, w, 0, w->sample, draws);
    wmr_measure(&k, w->state, parameters(s, w), draws, next, out);
    copy(w->state + WMR_FAST, next, WMR_STATE - WMR_FAST);
    w->sample += 1;
}

/* One plant step begins: what acts on the plant over it, of what a sample left to its steps. */
WMR_EXPORT void wmr_outside_step(const wmr_settings *s, wmr_loop *w, const double *held, double *out)
{
    double u[WMR_HELD], next[WMR_FAST], draws[WMR_STEP_DRAWS + 1];
    const double i = (double)w->step;
    copy(u, held, WMR_HELD);
    change(s, w);
    deliver(s, w, held, u);
    draw(s, w, 1, w->step, draws);
    wmr_act(&i, u, w->state, parameters(s, w), draws, next, out);
    copy(w->state + WMR_PLANT, next + WMR_PLANT, WMR_FAST - WMR_PLANT);
    w->step += 1;
}

/* The plant's state after plant step `step`: 0 if the run must end here. */
WMR_EXPORT int32_t wmr_outside_watch(wmr_loop *w, const double *plant, int64_t step)
{
    const int64_t reached = w->step;
    copy(w->state, plant, WMR_PLANT);
    w->step = step;
    monitor(w, w->running);
    w->step = reached;
    return w->running;
}

WMR_EXPORT void wmr_outside_findings(const wmr_loop *w, double *findings)
{
    memcpy(findings, w->findings, sizeof w->findings);
}
