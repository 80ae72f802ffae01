/* The closed loop: one control sample and its plant steps at a time, for one robot (WMR_LANES = 0)
   or for a robot in each lane of a vector.  The generated kernels hold reference, sensors,
   controller, disturbances, drives and plant; the loop keeps what graphs are bad at: counters,
   random numbers, the queue of commands under way, changes of parameters, the monitor, the log.
   No heap, no input or output, no globals: the caller owns every byte. */
#ifndef WMR_LOOP_H
#define WMR_LOOP_H

#include <stdint.h>

#include "kernels.h"

enum { WMR_RUNNING = 0, WMR_DIVERGED = 1, WMR_NON_FINITE = 2 };

/* |v| at which a run counts as diverged [m/s, rad/s]. */
#define WMR_SPEED_MAX 1e3

/* Margin to the limits before a state was seen: more than any. */
#define WMR_NO_MARGIN 1e300

/* Everything that stays the same during a run; pointers are the caller's, and what holds wmr_v is
   aligned as wmr_v is. */
typedef struct {
    int64_t samples, phases, windows;
    const int64_t *phase_start;        /* plant step at which each row of parameters begins, first 0 */
    const int64_t *window;             /* windows pairs: first sample, first sample after it */
    const uint64_t *key;               /* of the noise: WMR_WIDTH pairs */
    const volatile int32_t *cancelled; /* not 0: return at the next sample */
    const wmr_v *parameters;           /* phases rows of WMR_PARAMETERS */
    const wmr_v *start;                /* WMR_STATE */
    wmr_v *queue;                      /* commands in transit: 2 for each plant step of the delay */
    wmr_v *sums;                       /* windows rows of WMR_WINDOW */
    double *const *log;                /* a lane each: samples rows of WMR_ROW, or NULL; or NULL */
} wmr_settings;

/* Everything that a run changes, and what it takes from the parameters at its start. */
typedef struct {
    int64_t sample, step, phase, substeps, delay_steps;
    int64_t now; /* index of the valid state */
    wmr_m running;
    wmr_v clock[WMR_CLOCK];
    wmr_v states[2][WMR_STATE + 1]; /* a sample reads one and leaves its slow part in the other */
    wmr_v findings[WMR_FINDINGS];
#ifndef WMR_OUTSIDE
    wmr_v prepared_logged[WMR_SAMPLE_LOGGED_PREPARED + 1]; /* of this phase's parameters alone */
#ifdef WMR_SAMPLE_WATCHED_PREPARED /* the kernels do runs without a log, too */
    wmr_v prepared_watched[WMR_SAMPLE_WATCHED_PREPARED + 1];
#endif
    wmr_v prepared_step[WMR_STEP_PREPARED + 1];
#endif
} wmr_loop;

/* The state that holds now, and where a sample leaves its part of the next.  With WMR_ONE_STATE
   they stay in their places, so that a compiler with many registers may keep them there. */
#ifdef WMR_ONE_STATE
static inline wmr_v *wmr_loop_state(wmr_loop *w) { return w->states[0]; }
static inline wmr_v *wmr_loop_next(wmr_loop *w) { return w->states[1]; }
#else
static inline wmr_v *wmr_loop_state(wmr_loop *w) { return w->states[w->now]; }
static inline wmr_v *wmr_loop_next(wmr_loop *w) { return w->states[!w->now]; }
#endif

void wmr_loop_start(const wmr_settings *s, wmr_loop *w);

/* One control sample and its plant steps; `row` (WMR_ROW numbers) may be NULL where the kernels do
   runs without a log. */
void wmr_loop_sample(const wmr_settings *s, wmr_loop *w, wmr_v *row);

/* A whole run from the start; 0, or 1 if it was cancelled. */
int wmr_loop_run(const wmr_settings *s, wmr_loop *w);

#endif
