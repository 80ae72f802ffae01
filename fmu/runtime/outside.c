/* The loop for parts that are coupled from outside: the plant alone, or reference and controller too
   (WMR_MEASURED).  Whatever else there is, with disturbances, drives, the queue of commands, random
   numbers and the monitor, is that of loop.c.  The state has the loop's layout; what belongs to the
   parts outside stays at rest in it. */
#define WMR_KERNEL static
#define WMR_LANES 0
#define WMR_OUTSIDE

#include "export.h"
#include "kernels.c"
#include "noise.c"
#include "loop.c"

#ifdef WMR_MEASURED
#define SHOWN WMR_MEASURED
#else
#define SHOWN (WMR_HELD + WMR_ROW)
#endif

/* Sizes of settings and loop [bytes], of a sample and of the acting numbers [numbers]. */
WMR_EXPORT void wmr_outside_sizes(int64_t sizes[4])
{
    sizes[0] = (int64_t)sizeof(wmr_settings);
    sizes[1] = (int64_t)sizeof(wmr_loop);
    sizes[2] = SHOWN;
    sizes[3] = WMR_ACTING;
}

/* 0 if the run ends before its first step. */
WMR_EXPORT int32_t wmr_outside_start(const wmr_settings *s, wmr_loop *w)
{
    wmr_loop_start(s, w);
    return w->running;
}

/* One control sample of a plant's state: what the sensors show, and what disturbs it; of a whole loop
   what is held over the sample, and a row of the log. */
WMR_EXPORT void wmr_outside_sample(const wmr_settings *s, wmr_loop *w, const double *plant, double *out)
{
    double next[WMR_STATE - WMR_FAST + 1], draws[WMR_SAMPLE_DRAWS + 1];
    const double k = (double)w->sample;
    copy(wmr_loop_state(w), plant, WMR_PLANT);
    change(s, w);
    draw(s, w, 0, 1, w->sample, draws);
#ifdef WMR_MEASURED
    wmr_measure(&k, wmr_loop_state(w), parameters(s, w), draws, next, out);
#else
    wmr_sample_logged(&k, wmr_loop_state(w), parameters(s, w), draws, next, out, out + WMR_HELD);
#endif
    w->findings[WMR_FOUND_SAMPLES] += 1.0;
    copy(wmr_loop_state(w) + WMR_FAST, next, WMR_STATE - WMR_FAST);
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
    draw(s, w, 1, 1, w->step, draws);
    wmr_act(&i, u, wmr_loop_state(w), parameters(s, w), draws, next, out);
    copy(wmr_loop_state(w) + WMR_PLANT, next + WMR_PLANT, WMR_FAST - WMR_PLANT);
    w->step += 1;
}

/* The plant's state after plant step `step`: 0 if the run must end here. */
WMR_EXPORT int32_t wmr_outside_watch(wmr_loop *w, const double *plant, int64_t step)
{
    const int64_t reached = w->step;
    copy(wmr_loop_state(w), plant, WMR_PLANT);
    w->step = step;
    monitor(w, w->running);
    w->step = reached;
    return w->running;
}

WMR_EXPORT void wmr_outside_findings(const wmr_loop *w, double *findings)
{
    memcpy(findings, w->findings, sizeof w->findings);
}
