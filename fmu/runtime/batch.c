#include "batch.h"

#include <string.h>

#include "noise.h"

#define HALF_PI 1.5707963267948966
#define SPEED_MAX 1e3

enum { DIVERGED = 1, NON_FINITE = 2 };
enum { LIMIT = 0, POSE_NOISE = 2, CORRECTION = 3, VELOCITY_NOISE = 4, STD = 6, TRUNCATE = 7, LAG = 8,
       PUSH = 9, BOUND = 11 };

/* What changes during a run. */
typedef struct {
    int64_t sample, step, phase;
    wmr_v plant[WMR_PLANT_NX];
    wmr_v controller[WMR_CONTROLLER_NX + 1];
    wmr_v estimate[WMR_ESTIMATOR_NX];
    wmr_v applied[2], speed_max[2], torque_max;
    wmr_v violations, first_step, first_axis, stop, stop_step, stop_axis, samples;
    wmr_v least[2], left_sample, left_axis, clipped[2];
    wmr_m running;
} batch;

static void copy_lanes(wmr_v *to, const wmr_v *from, size_t count)
{
    memcpy(to, from, count * sizeof(wmr_v));
}

static void set(wmr_v *where, wmr_m which, wmr_v value)
{
    *where = wmr_choose(which, value, *where);
}

static void stop(batch *w, wmr_m which, double reason, double axis)
{
    set(&w->stop, which, wmr_all(reason));
    set(&w->stop_step, which, wmr_all((double)w->step));
    set(&w->stop_axis, which, wmr_all(axis));
}

static void count_violations(batch *w, wmr_m outside, wmr_m linear)
{
    const wmr_m first = outside & (wmr_m)(w->first_step < 0.0);
    set(&w->first_axis, first, wmr_choose(linear, wmr_all(1.0), wmr_all(2.0)));
    set(&w->first_step, first, wmr_all((double)w->step));
    w->violations += wmr_number(outside);
}

/* Limits and finiteness of the states that the lanes have now, in the order of loop.c. */
static void monitor(const wmr_batch_settings *s, batch *w, wmr_m moved)
{
    const wmr_v linear = wmr_abs(w->plant[3]), angular = wmr_abs(w->plant[4]);
    const wmr_m first = moved & wmr_finite(linear), both = first & wmr_finite(angular);
    const wmr_m beyond[2] = {(wmr_m)(linear > s->numbers[LIMIT]),
                             (wmr_m)(angular > s->numbers[LIMIT + 1])};
    set(&w->speed_max[0], first & (wmr_m)(linear > w->speed_max[0]), linear);
    set(&w->speed_max[1], both & (wmr_m)(angular > w->speed_max[1]), angular);
    if (wmr_some(both & (beyond[0] | beyond[1]))) {
        count_violations(w, both & (beyond[0] | beyond[1]), beyond[0]);
    }
    const wmr_m fast = first & (wmr_m)(linear >= SPEED_MAX);
    const wmr_m turning = both & ~fast & (wmr_m)(angular >= SPEED_MAX);
    const wmr_m ended = fast | turning | (moved & ~both);
    if (wmr_some(ended)) {
        stop(w, fast, DIVERGED, 1.0);
        stop(w, turning, DIVERGED, 2.0);
        stop(w, first & ~both, NON_FINITE, 2.0);
        stop(w, moved & ~first, NON_FINITE, 1.0);
        w->running &= ~ended;
    }
}

static void start(const wmr_batch_settings *s, batch *w)
{
    memset(w, 0, sizeof *w);
    copy_lanes(w->plant, s->plant_start, WMR_PLANT_NX);
    copy_lanes(w->controller, s->controller_start, WMR_CONTROLLER_NX);
    if (s->delay_steps > 0) {
        memset(s->delay_line, 0, 2 * (size_t)s->delay_steps * sizeof(wmr_v));
    }
    memset(s->sums, 0, (size_t)s->windows * WMR_SUMS * sizeof(wmr_v));
    w->first_step = w->left_sample = wmr_all(-1.0);
    w->running = wmr_always();
    monitor(s, w, w->running);
}

/* The adversary of loop.c: away from rest on each axis. */
static void push(const wmr_batch_settings *s, const batch *w, wmr_v noise[2])
{
    const wmr_v *most = s->numbers + PUSH;
    const wmr_v along = wmr_choose((wmr_m)(w->plant[3] < 0.0), -most[0], most[0]);
    const wmr_v around = wmr_choose((wmr_m)(w->plant[4] < 0.0), -most[1], most[1]);
    noise[0] += along + around;
    noise[1] += along - around;
}

static void measure(const wmr_batch_settings *s, batch *w, wmr_v *pose, wmr_v *v)
{
    wmr_v error[2] = {wmr_all(0.0), wmr_all(0.0)}, u[WMR_ESTIMATOR_NU], next[WMR_ESTIMATOR_NX];
    copy_lanes(pose, w->plant, 3);
    if (s->pose_every > 0) {
        if (wmr_some((wmr_m)(s->numbers[POSE_NOISE] > 0.0))) {
            wmr_uniform_pair(s->key, (uint64_t)w->sample, WMR_STREAM_POSE, error);
        }
        copy_lanes(u, w->plant, WMR_PLANT_NX);
        u[0] += s->numbers[POSE_NOISE] * error[0];
        u[1] += s->numbers[POSE_NOISE] * error[1];
        u[5] = w->sample == 0 ? wmr_all(1.0)
             : w->sample % s->pose_every == 0 ? s->numbers[CORRECTION] : wmr_all(0.0);
        wmr_estimator_step(u, w->estimate, s->estimator_parameters, next);
        copy_lanes(w->estimate, next, WMR_ESTIMATOR_NX);
        copy_lanes(pose, next, 3);
    }
    const wmr_v *half = s->numbers + VELOCITY_NOISE;
    error[0] = error[1] = wmr_all(0.0);
    if (wmr_some((wmr_m)(half[0] > 0.0) | (wmr_m)(half[1] > 0.0))) {
        wmr_uniform_pair(s->key, (uint64_t)w->sample, WMR_STREAM_VELOCITY, error);
    }
    v[0] = w->plant[3] + half[0] * error[0];
    v[1] = w->plant[4] + half[1] * error[1];
}

static void actuate(const wmr_batch_settings *s, batch *w, const wmr_v command[2])
{
    wmr_v delayed[2] = {command[0], command[1]};
    if (s->delay_steps > 0) {
        wmr_v *slot = s->delay_line + 2 * (w->step % s->delay_steps);
        copy_lanes(delayed, slot, 2);
        copy_lanes(slot, command, 2);
    }
    for (int i = 0; i < 2; ++i) {
        w->applied[i] = delayed[i] + s->numbers[LAG] * (w->applied[i] - delayed[i]);
    }
}

static void plant_steps(const wmr_batch_settings *s, batch *w, const wmr_v torque[2], const wmr_v noise[2])
{
    wmr_v u[4] = {torque[0], torque[1], noise[0], noise[1]}, next[WMR_PLANT_NX];
    for (int64_t i = 0; i < s->substeps && wmr_some(w->running); ++i) {
        const wmr_m moving = w->running;
        while (w->phase + 1 < s->phases && w->step >= s->phase_start[w->phase + 1]) {
            w->phase += 1;
        }
        if (!s->actuator_ideal) {
            actuate(s, w, torque);
            copy_lanes(u, w->applied, 2);
        }
        wmr_plant_step(u, w->plant, s->plant_parameters + w->phase * WMR_PLANT_NP, next);
        for (int k = 0; k < WMR_PLANT_NX; ++k) {
            w->plant[k] = wmr_choose(moving, next[k], w->plant[k]);
        }
        w->step += 1;
        monitor(s, w, moving);
    }
}

/* Adds this sample to the windows that it is in. */
static void add_up(const wmr_batch_settings *s, batch *w, const wmr_v *u, const wmr_v torque[2])
{
    wmr_v e[3], sums[WMR_SUMS];
    wmr_tracking_error(u, w->plant, e);
    const wmr_v dx = w->plant[0] - u[0], dy = w->plant[1] - u[1], turn = w->plant[2] - u[2];
    sums[0] = dx * dx + dy * dy;
    sums[1] = turn * turn;
    for (int i = 0; i < 3; ++i) {
        sums[2 + i] = e[i] * e[i];
    }
    sums[5] = torque[0] * torque[0] + torque[1] * torque[1];
    sums[6] = wmr_all(1.0);
    for (int64_t k = 0; k < s->windows; ++k) {
        if (w->sample >= s->window[2 * k] && w->sample < s->window[2 * k + 1]) {
            for (int i = 0; i < WMR_SUMS; ++i) {
                const wmr_m which = w->running;
                s->sums[WMR_SUMS * k + i] += (wmr_v)((wmr_m)sums[i] & which);
            }
        }
    }
    const wmr_v most = wmr_max(wmr_abs(torque[0]), wmr_abs(torque[1]));
    set(&w->torque_max, w->running & ~(wmr_m)(most <= w->torque_max), most);
    w->samples += wmr_number(w->running);
}

/* What the guard did, or would have, and whether the motion contradicts its bounds. */
static void watch(const wmr_batch_settings *s, batch *w, const wmr_v seen[WMR_WATCHED])
{
    const wmr_v *least = seen + 2, *bound = s->numbers + BOUND;
    const wmr_m linear = (wmr_m)(least[0] > bound[0]), angular = (wmr_m)(least[1] > bound[1]);
    const wmr_m first = w->running & (linear | angular) & (wmr_m)(w->left_sample < 0.0);
    set(&w->left_axis, first, wmr_choose(linear, wmr_all(1.0), wmr_all(2.0)));
    set(&w->left_sample, first, wmr_all((double)w->sample));
    for (int i = 0; i < 2; ++i) {
        set(&w->least[i], w->running & (wmr_m)(least[i] > w->least[i]), least[i]);
        w->clipped[i] += wmr_number(w->running & wmr_truth(seen[i]));
    }
}

static void write_row(const batch *w, double t, const wmr_v *u, const wmr_v torque[2],
                      const wmr_v noise[2], wmr_v *row)
{
    row[0] = wmr_all(t);
    copy_lanes(row + 1, w->plant, WMR_PLANT_NX);
    row[6] = w->plant[2] + HALF_PI;
    copy_lanes(row + 7, u, WMR_REFERENCE_NY);
    copy_lanes(row + 14, torque, 2);
    copy_lanes(row + 16, noise, 2);
    wmr_tracking_error(u, w->plant, row + 18);
}

/* A row of all lanes becomes a row in the log of each. */
static void deal(double *const *log, int64_t sample, const wmr_v *row)
{
    for (int i = 0; i < WMR_LANES; ++i) {
        double *to = log[i] ? log[i] + sample * WMR_ROW : 0;
        for (int k = 0; to && k < WMR_ROW; ++k) {
            to[k] = row[k][i];
        }
    }
}

static void sample(const wmr_batch_settings *s, batch *w)
{
    wmr_v u[WMR_CONTROLLER_NU], next[WMR_CONTROLLER_NX + 1], torque[2], noise[2];
    wmr_v seen[WMR_WATCHED];
    const double t = (double)w->sample * s->control;
    const wmr_v time = wmr_all(t);
    wmr_v row[WMR_ROW];
    wmr_reference(&time, s->reference_parameters, u);
    measure(s, w, u + 7, u + 10);
    if (s->log) {
        wmr_controller_logged(u, w->controller, s->controller_parameters, next, torque, row + 21);
    } else {
        wmr_controller_watched(u, w->controller, s->controller_parameters, next, torque, seen);
        watch(s, w, seen);
    }
    noise[0] = noise[1] = wmr_all(0.0);
    if (wmr_some((wmr_m)(s->numbers[STD] > 0.0))) {
        wmr_torque_noise(s->key, (uint64_t)w->sample, s->numbers[STD], s->numbers[TRUNCATE], noise);
    }
    push(s, w, noise);
    if (s->log) {
        write_row(w, t, u, torque, noise, row);
        deal(s->log, w->sample, row);
    }
    add_up(s, w, u, torque);
    copy_lanes(w->controller, next, WMR_CONTROLLER_NX);
    if (s->actuator_ideal) {
        copy_lanes(w->applied, torque, 2);
    }
    plant_steps(s, w, torque, noise);
    w->sample += 1;
}

static void write_findings(const batch *w, wmr_v *found)
{
    copy_lanes(found, w->plant, WMR_PLANT_NX);
    const wmr_v rest[] = {
        w->speed_max[0], w->speed_max[1], w->violations, w->first_step, w->first_axis, w->stop,
        w->stop_step, w->stop_axis, w->samples, w->torque_max, w->least[0], w->least[1],
        w->left_sample, w->left_axis, w->clipped[0], w->clipped[1],
    };
    copy_lanes(found + WMR_PLANT_NX, rest, WMR_FINDINGS - WMR_PLANT_NX);
}

int wmr_batch_run(const wmr_batch_settings *s)
{
    batch w;
    start(s, &w);
    while (w.sample < s->samples && wmr_some(w.running) && !*s->cancelled) {
        sample(s, &w);
    }
    write_findings(&w, s->findings);
    return *s->cancelled != 0;
}
