/* The closed loop of the native engine as a model: one control sample of fmu/runtime/loop.c at the
   start of each control period.  Outputs are those of the sample's log; pose and velocity are those
   of the last control instant that was reached. */
#include <math.h>
#include <string.h>

#include "instance.h"
#include "loop_tables.h"
#include "seed.h"

#define PERIOD_TOLERANCE 1e-6

static void pick(const double *values, const int *rows, int count, double *to)
{
    for (int i = 0; i < count; ++i) {
        to[i] = values[rows[i]];
    }
}

/* First plant step that starts at or after `time`. */
static int64_t first_step(double time, double step)
{
    const double near = floor(time / step + 0.5);
    const int on_grid = fabs(near * step - time) <= 1e-9 * (time > 1.0 ? time : 1.0);
    return (int64_t)(on_grid ? near : ceil(time / step));
}

/* The plant's parameters from the start and after each change. */
static void set_phases(wmr_scratch *to, const double *values)
{
    pick(values, PLANT_ROWS, WMR_PLANT_NP, to->plant);
    to->phase_start[0] = 0;
    for (int k = 0; k < WMR_CHANGES; ++k) {
        double *row = to->plant + (k + 1) * WMR_PLANT_NP;
        memcpy(row, row - WMR_PLANT_NP, WMR_PLANT_NP * sizeof(double));
        to->phase_start[k + 1] =
            first_step(values[CHANGE_TIME_ROWS[k]], values[WMR_AT_CLOCK_PLANT]);
        for (int i = 0; i < WMR_PLANT_NP; ++i) {
            row[i] = CHANGE_ROWS[k][i] ? values[CHANGE_ROWS[k][i]] : row[i];
        }
    }
}

static int64_t pose_every(const double *v)
{
    const double period = v[WMR_AT_SENSOR_POSE_PERIOD];
    if (period == 0.0 && v[WMR_AT_SENSOR_POSE_NOISE] == 0.0 && v[WMR_AT_SENSOR_CORRECTION] == 1.0) {
        return 0;
    }
    const double samples = rint(period / v[WMR_AT_CLOCK_CONTROL]);
    return samples < 1.0 ? 1 : (int64_t)samples;
}

static void set_numbers(wmr_settings *to, const double *v)
{
    to->control = v[WMR_AT_CLOCK_CONTROL];
    to->plant = v[WMR_AT_CLOCK_PLANT];
    to->substeps = (int64_t)rint(to->control / to->plant);
    to->samples = INT64_MAX;
    to->phases = WMR_CHANGES + 1;
    to->pose_every = pose_every(v);
    to->pose_noise = v[WMR_AT_SENSOR_POSE_NOISE];
    to->correction = v[WMR_AT_SENSOR_CORRECTION];
    memcpy(to->v_u1, v + WMR_AT_LIMITS_V_U1, sizeof to->v_u1);
    memcpy(to->velocity_noise, v + WMR_AT_SENSOR_VELOCITY_NOISE, sizeof to->velocity_noise);
    to->torque_std = v[WMR_AT_DISTURBANCE_STD];
    to->torque_truncate = v[WMR_AT_DISTURBANCE_TRUNCATE];
    wmr_push_torque(v + WMR_AT_DISTURBANCE_PUSH, v + WMR_AT_ROBOT_R, v + WMR_AT_ROBOT_L,
                    to->push_torque);
    to->delay_steps = (int64_t)rint(v[WMR_AT_ACTUATOR_DELAY] / to->plant);
    to->actuator_ideal = v[WMR_AT_ACTUATOR_LAG] == 0.0 && v[WMR_AT_ACTUATOR_DELAY] == 0.0;
    to->lag_decay = v[WMR_AT_ACTUATOR_LAG] > 0.0 ? exp(-to->plant / v[WMR_AT_ACTUATOR_LAG]) : 0.0;
    wmr_seed_key((uint64_t)v[WMR_AT_SEED], to->key);
}

void kind_restore(struct wmr_instance *s)
{
    wmr_scratch *to = &s->scratch;
    const double *v = s->state.values;
    pick(v, REFERENCE_ROWS, WMR_REFERENCE_NP, to->reference);
    pick(v, CONTROLLER_ROWS, WMR_CONTROLLER_NP, to->controller);
    pick(v, ESTIMATOR_ROWS, WMR_ESTIMATOR_NP, to->estimator);
    memcpy(to->pose, v + WMR_AT_INITIAL, sizeof to->pose);
    memcpy(to->start, CONTROLLER_START, sizeof to->start);
    set_phases(to, v);
    set_numbers(&to->settings, v);
    to->settings.reference_parameters = to->reference;
    to->settings.controller_parameters = to->controller;
    to->settings.estimator_parameters = to->estimator;
    to->settings.plant_parameters = to->plant;
    to->settings.phase_start = to->phase_start;
    to->settings.plant_start = to->pose;
    to->settings.controller_start = to->start;
    to->settings.delay_line = s->state.memory.delay;
}

/* Whether a is a whole multiple of b, and not too large a one. */
static int fits(double a, double b, double most)
{
    const double ratio = a / b, near = rint(ratio);
    return ratio <= most && fabs(ratio - near) <= 1e-9 * (near > 1.0 ? near : 1.0);
}

int kind_start(struct wmr_instance *s)
{
    const double *v = s->state.values, step = v[WMR_AT_CLOCK_PLANT];
    const int whole =
        fits(v[WMR_AT_CLOCK_CONTROL], step, 1e5) && v[WMR_AT_CLOCK_CONTROL] >= 0.5 * step;
    if (!whole || !fits(v[WMR_AT_ACTUATOR_DELAY], step, WMR_DELAY_MAX)) {
        return 0;
    }
    memset(&s->state.memory, 0, sizeof s->state.memory);
    kind_restore(s);
    wmr_loop_start(&s->scratch.settings, &s->state.memory.loop);
    return 1;
}

double kind_steps(const struct wmr_instance *s, double t, double h)
{
    (void)t;
    return h / s->state.values[WMR_AT_CLOCK_PLANT];
}

static double sample_time(const struct wmr_instance *s, int64_t k)
{
    return s->state.start_time + (double)k * s->scratch.settings.control;
}

static void publish_monitor(struct wmr_instance *s)
{
    const wmr_loop *loop = &s->state.memory.loop;
    double *values = s->state.values;
    values[WMR_AT_VIOLATIONS] = (double)loop->violations;
    memcpy(values + WMR_AT_MAX_ABS_V, loop->speed_max, sizeof loop->speed_max);
}

/* Pose, velocity and psi at the control instant that was reached. */
static void publish_plant(struct wmr_instance *s, const double *state)
{
    double *values = s->state.values + WMR_Y;
    memcpy(values, state, WMR_PLANT_NX * sizeof(double));
    values[WMR_PLANT_NX] = state[2] + 1.5707963267948966;
}

static void publish(struct wmr_instance *s)
{
    const wmr_memory *memory = &s->state.memory;
    memcpy(s->state.values + WMR_Y, memory->row + 1, (WMR_ROW - 1) * sizeof(double));
    publish_monitor(s);
}

static void sample(struct wmr_instance *s)
{
    wmr_memory *memory = &s->state.memory;
    wmr_loop_sample(&s->scratch.settings, &memory->loop, memory->row);
    memory->count += 1;
    publish(s);
    s->state.finished = memory->loop.stop != WMR_RUNNING;
}

double kind_advance(struct wmr_instance *s, double t, double h)
{
    const double slack = PERIOD_TOLERANCE * s->scratch.settings.control, end = t + h;
    while (!s->state.finished && sample_time(s, s->state.memory.count) < end - slack) {
        sample(s);
        const double next = sample_time(s, s->state.memory.count);
        if (next > end + slack) {
            break;
        }
        publish_plant(s, s->state.memory.loop.plant);
        if (s->pause && next < end - slack && s->pause(s, next)) {
            return next;
        }
    }
    if (sample_time(s, s->state.memory.count) <= end + slack) {
        publish_plant(s, s->state.memory.loop.plant);
    }
    return end;
}

/* Before the first step: the log of sample 0, taken on a copy. */
void kind_refresh(struct wmr_instance *s)
{
    if (s->state.memory.count == 0) {
        wmr_memory *memory = &s->state.memory;
        kind_restore(s);
        wmr_loop_start(&s->scratch.settings, &memory->loop);
        const wmr_memory kept = *memory;
        wmr_loop_sample(&s->scratch.settings, &memory->loop, memory->row);
        publish(s);
        memory->loop = kept.loop;
        memcpy(memory->delay, kept.delay, sizeof kept.delay);
        publish_monitor(s);
    }
}
