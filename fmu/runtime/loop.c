#include "loop.h"

#include <math.h>
#include <string.h>

#include "noise.h"

static const double HALF_PI = 1.5707963267948966;

static void copy(double *to, const double *from, size_t count)
{
    memcpy(to, from, count * sizeof(double));
}

static void stop(wmr_loop *w, int64_t reason, int64_t axis)
{
    w->stop = reason;
    w->stop_step = w->step;
    w->stop_axis = axis;
}

/* Limits and finiteness of the state that the plant has now. */
static void monitor(const wmr_settings *s, wmr_loop *w)
{
    int outside = 0;
    for (int i = 0; i < 2; ++i) {
        const double speed = fabs(w->plant[3 + i]);
        if (!isfinite(speed)) {
            stop(w, WMR_NON_FINITE, i + 1);
            return;
        }
        if (speed >= WMR_SPEED_MAX && w->stop == WMR_RUNNING) {
            stop(w, WMR_DIVERGED, i + 1);
        }
        if (speed > w->speed_max[i]) {
            w->speed_max[i] = speed;
        }
        if (speed > s->v_u1[i] && !outside) {
            outside = i + 1;
        }
    }
    if (outside) {
        w->violations += 1;
        if (w->first_step < 0) {
            w->first_step = w->step;
            w->first_axis = outside;
        }
    }
}

void wmr_loop_start(const wmr_settings *s, wmr_loop *w)
{
    memset(w, 0, sizeof *w);
    copy(w->plant, s->plant_start, WMR_PLANT_NX);
    copy(w->controller, s->controller_start, WMR_CONTROLLER_NX);
    for (int64_t i = 0; i < 2 * s->delay_steps; ++i) {
        s->delay_line[i] = 0.0;
    }
    w->first_step = -1;
    monitor(s, w);
}

/* Pose that the law sees: exact, or dead-reckoned and corrected now and then. */
static void measure_pose(const wmr_settings *s, wmr_loop *w, double *pose)
{
    if (s->pose_every == 0) {
        copy(pose, w->plant, 3);
        return;
    }
    double u[WMR_ESTIMATOR_NU], next[WMR_ESTIMATOR_NX], error[2] = {0.0, 0.0};
    if (s->pose_noise > 0.0) {
        wmr_uniform_pair(s->key, (uint64_t)w->sample, WMR_STREAM_POSE, error);
    }
    copy(u, w->plant, WMR_PLANT_NX);
    u[0] += s->pose_noise * error[0];
    u[1] += s->pose_noise * error[1];
    u[5] = w->sample == 0 ? 1.0 : (w->sample % s->pose_every == 0 ? s->correction : 0.0);
    wmr_estimator_step(u, w->estimate, s->estimator_parameters, next);
    copy(w->estimate, next, WMR_ESTIMATOR_NX);
    copy(pose, next, 3);
}

static void measure_velocity(const wmr_settings *s, const wmr_loop *w, double *v)
{
    double error[2] = {0.0, 0.0};
    if (s->velocity_noise[0] > 0.0 || s->velocity_noise[1] > 0.0) {
        wmr_uniform_pair(s->key, (uint64_t)w->sample, WMR_STREAM_VELOCITY, error);
    }
    v[0] = w->plant[3] + s->velocity_noise[0] * error[0];
    v[1] = w->plant[4] + s->velocity_noise[1] * error[1];
}

/* Torque behind delay and lag, held over the plant step that begins now. */
static void actuate(const wmr_settings *s, wmr_loop *w, const double *command)
{
    double delayed[2] = {command[0], command[1]};
    if (s->delay_steps > 0) {
        double *slot = s->delay_line + 2 * (w->step % s->delay_steps);
        copy(delayed, slot, 2);
        copy(slot, command, 2);
    }
    for (int i = 0; i < 2; ++i) {
        w->applied[i] = delayed[i] + s->lag_decay * (w->applied[i] - delayed[i]);
    }
}

static void plant_steps(const wmr_settings *s, wmr_loop *w, const double *torque, const double *noise)
{
    double u[4] = {torque[0], torque[1], noise[0], noise[1]}, next[WMR_PLANT_NX];
    if (s->actuator_ideal) {
        copy(w->applied, torque, 2);
    }
    for (int64_t i = 0; i < s->substeps && w->stop == WMR_RUNNING; ++i) {
        while (w->phase + 1 < s->phases && w->step >= s->phase_start[w->phase + 1]) {
            w->phase += 1;
        }
        if (!s->actuator_ideal) {
            actuate(s, w, torque);
            copy(u, w->applied, 2);
        }
        wmr_plant_step(u, w->plant, s->plant_parameters + w->phase * WMR_PLANT_NP, next);
        copy(w->plant, next, WMR_PLANT_NX);
        w->step += 1;
        monitor(s, w);
    }
}

/* All of a row but the controller's diagnostics, which stand at its end. */
static void write_row(const wmr_loop *w, double t, const double *u, const double *torque,
                      const double *noise, double *row)
{
    row[0] = t;
    copy(row + 1, w->plant, WMR_PLANT_NX);
    row[6] = w->plant[2] + HALF_PI;
    copy(row + 7, u, WMR_REFERENCE_NY);
    copy(row + 14, torque, 2);
    copy(row + 16, noise, 2);
    wmr_tracking_error(u, w->plant, row + 18);
}

/* An adversary: more torque in the direction in which each axis moves, forward at rest. */
static void push(const wmr_settings *s, const wmr_loop *w, double *noise)
{
    const double along = w->plant[3] < 0.0 ? -s->push_torque[0] : s->push_torque[0];
    const double around = w->plant[4] < 0.0 ? -s->push_torque[1] : s->push_torque[1];
    noise[0] += along + around;
    noise[1] += along - around;
}

void wmr_loop_sample(const wmr_settings *s, wmr_loop *w, double *row)
{
    double u[WMR_CONTROLLER_NU], next[WMR_CONTROLLER_NX + 1], torque[2], noise[2] = {0.0, 0.0};
    const double t = (double)w->sample * s->control;
    wmr_reference(&t, s->reference_parameters, u);
    measure_pose(s, w, u + 7);
    measure_velocity(s, w, u + 10);
    if (row) {
        wmr_controller_logged(u, w->controller, s->controller_parameters, next, torque, row + 21);
    } else {
        wmr_controller_step(u, w->controller, s->controller_parameters, next, torque);
    }
    if (s->torque_std > 0.0) {
        wmr_torque_noise(s->key, (uint64_t)w->sample, s->torque_std, s->torque_truncate, noise);
    }
    push(s, w, noise);
    if (row) {
        write_row(w, t, u, torque, noise, row);
    }
    copy(w->controller, next, WMR_CONTROLLER_NX);
    plant_steps(s, w, torque, noise);
    w->sample += 1;
}

int64_t wmr_loop_run(const wmr_settings *s, wmr_loop *w, double *log)
{
    wmr_loop_start(s, w);
    while (w->sample < s->samples && w->stop == WMR_RUNNING) {
        wmr_loop_sample(s, w, log ? log + w->sample * WMR_ROW : 0);
    }
    return w->sample;
}
