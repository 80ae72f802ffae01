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

/* Each number to its row; one without a row has row 0, which is the time. */
static void put(const double *from, const int *rows, int count, double *values)
{
    for (int i = 0; i < count; ++i) {
        values[rows[i]] = rows[i] ? from[i] : values[rows[i]];
    }
}

/* First plant step that starts at or after `time`. */
static int64_t first_step(double time, double step)
{
    const double near = floor(time / step + 0.5);
    const int on_grid = fabs(near * step - time) <= 1e-9 * (time > 1.0 ? time : 1.0);
    return (int64_t)(on_grid ? near : ceil(time / step));
}

/* The loop's parameters from the start and after each change. */
static void set_phases(wmr_scratch *to, const double *values)
{
    pick(values, PARAMETER_ROWS, WMR_PARAMETERS, to->parameters);
    to->phase_start[0] = 0;
    for (int k = 0; k < WMR_CHANGES; ++k) {
        double *row = to->parameters + (k + 1) * WMR_PARAMETERS;
        memcpy(row, row - WMR_PARAMETERS, WMR_PARAMETERS * sizeof(double));
        to->phase_start[k + 1] = first_step(values[CHANGE_TIME_ROWS[k]], values[WMR_AT_STEP]);
        for (int i = 0; i < WMR_PARAMETERS; ++i) {
            row[i] = CHANGE_ROWS[k][i] ? values[CHANGE_ROWS[k][i]] : row[i];
        }
    }
}

void kind_restore(struct wmr_instance *s)
{
    wmr_scratch *to = &s->scratch;
    const double *v = s->state.values;
    for (int i = 0; i < WMR_STATE; ++i) {
        to->start[i] = START_ROWS[i] ? v[START_ROWS[i]] : START[i];
    }
    set_phases(to, v);
    wmr_seed_key((uint64_t)v[WMR_AT_SEED], to->key);
    memset(&to->settings, 0, sizeof to->settings);
    to->settings.samples = INT64_MAX;
    to->settings.phases = WMR_CHANGES + 1;
    to->settings.phase_start = to->phase_start;
    to->settings.key = to->key;
    to->settings.cancelled = &to->cancelled;
    to->settings.parameters = to->parameters;
    to->settings.start = to->start;
    to->settings.queue = s->state.memory.queue;
}

/* True if a is a whole multiple of b that is not too large. */
static int fits(double a, double b, double most)
{
    const double ratio = a / b, near = rint(ratio);
    return ratio <= most && fabs(ratio - near) <= 1e-9 * (near > 1.0 ? near : 1.0);
}

int kind_start(struct wmr_instance *s)
{
    const double step = s->state.values[WMR_AT_STEP], period = s->state.values[WMR_AT_PERIOD];
    if (!fits(period, step, 1e5) || period < 0.5 * step) {
        return 0;
    }
    kind_restore(s);
    wmr_loop_start(&s->scratch.settings, &s->state.memory.loop);
    return s->state.memory.loop.delay_steps <= WMR_DELAY_MAX;
}

double kind_steps(const struct wmr_instance *s, double t, double h)
{
    (void)t;
    return h / s->state.values[WMR_AT_STEP];
}

static double sample_time(const struct wmr_instance *s, int64_t k)
{
    return s->state.start_time + (double)k * s->state.values[WMR_AT_PERIOD];
}

static void publish_monitor(struct wmr_instance *s)
{
    put(s->state.memory.loop.findings, FOUND_ROWS, WMR_FINDINGS, s->state.values);
}

/* Columns of the log that the plant shows, at the control instant that was reached. */
static void publish_plant(struct wmr_instance *s)
{
    double shown[WMR_REACHED];
    wmr_reached(wmr_loop_state(&s->state.memory.loop), shown);
    put(shown, REACHED_ROWS, WMR_REACHED, s->state.values);
}

static void publish(struct wmr_instance *s)
{
    const wmr_memory *memory = &s->state.memory;
    put(memory->row, COLUMN_ROWS, WMR_ROW, s->state.values);
    publish_monitor(s);
}

static void sample(struct wmr_instance *s)
{
    wmr_memory *memory = &s->state.memory;
    wmr_loop_sample(&s->scratch.settings, &memory->loop, memory->row);
    memory->count += 1;
    publish(s);
    s->state.finished = !memory->loop.running;
}

double kind_advance(struct wmr_instance *s, double t, double h)
{
    const double slack = PERIOD_TOLERANCE * s->state.values[WMR_AT_PERIOD], end = t + h;
    while (!s->state.finished && sample_time(s, s->state.memory.count) < end - slack) {
        sample(s);
        const double next = sample_time(s, s->state.memory.count);
        if (next > end + slack) {
            break;
        }
        publish_plant(s);
        if (s->pause && next < end - slack && s->pause(s, next)) {
            return next;
        }
    }
    if (sample_time(s, s->state.memory.count) <= end + slack) {
        publish_plant(s);
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
        memcpy(memory->queue, kept.queue, sizeof kept.queue);
        publish_monitor(s);
    }
}
