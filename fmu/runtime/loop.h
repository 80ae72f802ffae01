/* The closed loop in C: reference, sensors, controller, actuators and plant, one control sample
   at a time.  No heap, no input or output, no globals: the caller owns every byte. */
#ifndef WMR_LOOP_H
#define WMR_LOOP_H

#include <stdint.h>

#include "kernels.h"

enum { WMR_RUNNING = 0, WMR_DIVERGED = 1, WMR_NON_FINITE = 2 };

/* |v| at which a run counts as diverged [m/s, rad/s]. */
#define WMR_SPEED_MAX 1e3

/* Columns of a log row: time, state, psi, reference, torque, noise, error, diagnostics. */
#define WMR_ROW (1 + WMR_PLANT_NX + 1 + WMR_REFERENCE_NY + 2 + 2 + 3 + WMR_CONTROLLER_ND)

/* Everything that stays the same during a run; pointers are the caller's. */
typedef struct {
    double control, plant;                /* control period, plant step [s] */
    int64_t samples, substeps;            /* control samples, plant steps in each */
    const double *reference_parameters;   /* WMR_REFERENCE_NP */
    const double *controller_parameters;  /* WMR_CONTROLLER_NP */
    const double *estimator_parameters;   /* WMR_ESTIMATOR_NP */
    const double *plant_parameters;       /* phases rows of WMR_PLANT_NP */
    const int64_t *phase_start;           /* plant step at which each row begins, the first 0 */
    int64_t phases;
    const double *plant_start;            /* WMR_PLANT_NX */
    const double *controller_start;       /* WMR_CONTROLLER_NX */
    double v_u1[2];                       /* velocity limits, for the monitor */
    int64_t pose_every;                   /* samples between poses; 0: the pose is exact */
    double pose_noise, correction;        /* half-width [m], gain */
    double velocity_noise[2];             /* half-widths [m/s, rad/s] */
    double torque_std, torque_truncate;   /* [N m], [standard deviations] */
    double push_torque[2];                /* along v1 on both wheels, along omega on right - left [N m] */
    uint64_t key[2];                      /* of the noise */
    int64_t actuator_ideal;               /* 1: torque acts at once */
    int64_t delay_steps;                  /* plant steps */
    double lag_decay;                     /* exp(-plant/lag), 0 without lag */
    double *delay_line;                   /* 2 * delay_steps */
} wmr_settings;

/* Everything that a run changes. */
typedef struct {
    int64_t sample, step, phase;
    double plant[WMR_PLANT_NX];
    double controller[WMR_CONTROLLER_NX + 1];
    double estimate[WMR_ESTIMATOR_NX];
    double applied[2];                    /* torque behind the actuator, without noise */
    double speed_max[2];                  /* max |v1|, |omega| */
    int64_t violations;                   /* plant steps outside the limits */
    int64_t first_step, first_axis;       /* of the first violation; -1, 0 where there is none */
    int64_t stop, stop_step, stop_axis;   /* WMR_RUNNING, or why and where the run ended */
} wmr_loop;

void wmr_loop_start(const wmr_settings *s, wmr_loop *w);

/* One control sample and its plant steps; `row` (WMR_ROW doubles) may be NULL. */
void wmr_loop_sample(const wmr_settings *s, wmr_loop *w, double *row);

/* A whole run from the start; returns the number of rows written. */
int64_t wmr_loop_run(const wmr_settings *s, wmr_loop *w, double *log);

#endif
