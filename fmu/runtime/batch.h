/* The closed loop of loop.h for WMR_LANES robots at once, one a lane, from kernels written for
   lanes.  No heap, no input or output, no globals.  Arrays of wmr_v are aligned as wmr_v is. */
#ifndef WMR_BATCH_H
#define WMR_BATCH_H

#include "arithmetic.h"

#include "kernels.h"

/* Columns of a log row, as in loop.h. */
#define WMR_ROW (1 + WMR_PLANT_NX + 1 + WMR_REFERENCE_NY + 2 + 2 + 3 + WMR_CONTROLLER_ND)

/* Sums over one window of samples: dx^2 + dy^2, dtheta^2, e1^2, e2^2, e3^2, tau_r^2 + tau_l^2, and
   the number of samples. */
#define WMR_SUMS 7

/* Numbers of each lane: v_u1 (2), pose noise, correction, velocity noise (2), standard deviation
   and truncation of the torque noise, decay of the lag, torque of the push along v1 (both wheels)
   and along omega (right - left), d_least that the guard's bounds admit (2). */
#define WMR_NUMBERS 13

/* What the controller shows in every run: clip_active (2), d_least (2). */
#define WMR_WATCHED 4

/* Findings of each lane: final plant state (WMR_PLANT_NX), max |v| (2), violations, plant step and
   axis of the first (-1, 0), reason (as in loop.h), plant step and axis of an early end, samples
   made, largest |torque|; and, of runs without a log: largest d_least (2), sample and axis of the
   first beyond its bound (-1, 0), samples with the clip active (2). */
#define WMR_FINDINGS (WMR_PLANT_NX + 16)

/* What all lanes share, and vectors with a number for each lane. */
typedef struct {
    double control, plant;               /* control period, plant step [s] */
    int64_t samples, substeps, phases, pose_every, actuator_ideal, delay_steps, windows;
    const int64_t *phase_start;          /* phases plant steps, the first 0 */
    const int64_t *window;               /* windows pairs: first sample, first sample after it */
    const uint64_t *key;                 /* WMR_LANES pairs */
    const volatile int32_t *cancelled;   /* not 0: return at the next sample */
    const wmr_v *reference_parameters, *controller_parameters, *estimator_parameters;
    const wmr_v *plant_parameters;       /* phases rows of WMR_PLANT_NP */
    const wmr_v *plant_start, *controller_start;
    const wmr_v *numbers;                /* WMR_NUMBERS */
    wmr_v *delay_line;                   /* 2 * delay_steps */
    wmr_v *sums;                         /* windows rows of WMR_SUMS */
    wmr_v *findings;                     /* WMR_FINDINGS */
    double *const *log;                  /* a lane each: samples rows of WMR_ROW, or NULL; or NULL */
} wmr_batch_settings;

/* Runs all lanes to the end; 0, or 1 if it was cancelled. */
int wmr_batch_run(const wmr_batch_settings *s);

#endif
