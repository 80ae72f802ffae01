#include "loop.h"

#include <string.h>

#include "noise.h"

#define TWO_PI 6.283185307179586
#define ATTEMPTS 64

/* A stream of random numbers: its number in the generator's counter, kind, pairs, whether it is for
   plant steps, and whether the numbers of a sample are held over its steps. */
typedef struct {
    uint64_t number;
    int normal, pairs, per_step, held;
} stream;

static const stream STREAMS[] = {WMR_STREAMS};
enum { STREAM_COUNT = sizeof STREAMS / sizeof STREAMS[0] };

static void copy(wmr_v *to, const wmr_v *from, size_t count)
{
    memcpy(to, from, count * sizeof(wmr_v));
}

static void set(wmr_v *where, wmr_m which, wmr_v value)
{
    *where = wmr_choose(which, value, *where);
}

static void stop(wmr_loop *w, wmr_m which, double reason, double axis)
{
    set(&w->findings[WMR_FOUND_STOP], which, wmr_all(reason));
    set(&w->findings[WMR_FOUND_STOP_STEP], which, wmr_all((double)w->step));
    set(&w->findings[WMR_FOUND_STOP_AXIS], which, wmr_all(axis));
}

static void count_violations(wmr_loop *w, wmr_m outside, wmr_m linear, wmr_m angular)
{
    wmr_v *found = w->findings;
    const wmr_m first = outside & wmr_mask(found[WMR_FOUND_FIRST_STEP] < 0.0);
    const wmr_v other = wmr_choose(angular, wmr_all(2.0), wmr_all(3.0));
    set(&found[WMR_FOUND_FIRST_AXIS], first, wmr_choose(linear, wmr_all(1.0), other));
    set(&found[WMR_FOUND_FIRST_STEP], first, wmr_all((double)w->step));
    found[WMR_FOUND_VIOLATIONS] += wmr_number(outside);
}

/* The end of lanes whose speeds `v` are beyond all measure, or no numbers. */
static void end_lanes(wmr_loop *w, wmr_m moved, const wmr_v v[2])
{
    const wmr_m first = moved & wmr_finite(v[0]), both = first & wmr_finite(v[1]);
    const wmr_m fast = first & wmr_mask(v[0] >= WMR_SPEED_MAX);
    const wmr_m turning = both & wmr_not(fast) & wmr_mask(v[1] >= WMR_SPEED_MAX);
    stop(w, fast, WMR_DIVERGED, 1.0);
    stop(w, turning, WMR_DIVERGED, 2.0);
    stop(w, first & wmr_not(both), WMR_NON_FINITE, 2.0);
    stop(w, moved & wmr_not(first), WMR_NON_FINITE, 1.0);
    w->running = w->running & wmr_not(fast | turning | (moved & wmr_not(both)));
}

/* Limits and finiteness of the states that the lanes have now. */
static void monitor(wmr_loop *w, wmr_m moved)
{
    const wmr_v *state = wmr_loop_state(w);
    const wmr_v signed_v[2] = {state[WMR_AT_V1], state[WMR_AT_OMEGA]};
    const wmr_v v[2] = {wmr_abs(signed_v[0]), wmr_abs(signed_v[1])};
    const wmr_v *high = w->clock + WMR_CLOCK_V_MAX_LINEAR, *low = w->clock + WMR_CLOCK_V_MIN_LINEAR;
    const wmr_v rim = v[0] + w->clock[WMR_CLOCK_HALF_TRACK] * v[1];
    const wmr_v margin[2] = {wmr_min(high[0] - signed_v[0], signed_v[0] - low[0]),
                             wmr_min(high[1] - signed_v[1], signed_v[1] - low[1])};
    wmr_v *most = w->findings + WMR_FOUND_MAX_V1, *least = w->findings + WMR_FOUND_MARGIN_V1;
    const wmr_m calm = wmr_mask(v[0] < WMR_SPEED_MAX) & wmr_mask(v[1] < WMR_SPEED_MAX);
    const wmr_m first = moved & wmr_finite(v[0]), both = first & wmr_finite(v[1]);
    const wmr_m linear = wmr_mask(margin[0] < 0.0), angular = wmr_mask(margin[1] < 0.0);
    const wmr_m outside = linear | angular | wmr_mask(rim > w->clock[WMR_CLOCK_WHEEL_SPEED]);
    set(&most[0], first & wmr_mask(v[0] > most[0]), v[0]);
    set(&most[1], both & wmr_mask(v[1] > most[1]), v[1]);
    set(&least[0], first & wmr_mask(margin[0] < least[0]), margin[0]);
    set(&least[1], both & wmr_mask(margin[1] < least[1]), margin[1]);
    if (wmr_some(both & outside)) {
        count_violations(w, both & outside, linear, angular);
    }
    if (wmr_some(moved & wmr_not(calm))) {
        end_lanes(w, moved, v);
    }
}

static const wmr_v *parameters(const wmr_settings *s, const wmr_loop *w)
{
    return s->parameters + w->phase * WMR_PARAMETERS;
}

/* Values that depend on the parameters alone. */
static void prepare(const wmr_settings *s, wmr_loop *w)
{
#ifdef WMR_OUTSIDE
    (void)s;
    (void)w;
#else
    const wmr_v *p = parameters(s, w);
    wmr_sample_logged_prepare(p, w->prepared_logged);
#ifdef WMR_SAMPLE_WATCHED_PREPARED
    wmr_sample_watched_prepare(p, w->prepared_watched);
#endif
    wmr_step_prepare(p, w->prepared_step);
#endif
}

/* Moves on to the parameters that hold from this plant step on. */
static void change(const wmr_settings *s, wmr_loop *w)
{
    const int64_t before = w->phase;
    while (w->phase + 1 < s->phases && w->step >= s->phase_start[w->phase + 1]) {
        w->phase += 1;
    }
    if (w->phase != before) {
        prepare(s, w);
    }
}

/* The nearest whole number of a number that all lanes share. */
static int64_t whole(wmr_v number)
{
    return (int64_t)(WMR_AT(number, 0) + 0.5);
}

void wmr_loop_start(const wmr_settings *s, wmr_loop *w)
{
    memset(w, 0, sizeof *w);
    copy(wmr_loop_state(w), s->start, WMR_STATE);
    wmr_clock(s->parameters, w->clock);
    prepare(s, w);
    w->substeps = whole(w->clock[WMR_CLOCK_CONTROL] / w->clock[WMR_CLOCK_PLANT]);
    w->delay_steps = whole(w->clock[WMR_CLOCK_DELAY_STEPS]);
    if (w->delay_steps > 0) {
        memset(s->queue, 0, 2 * (size_t)w->delay_steps * sizeof(wmr_v));
    }
    if (s->windows > 0) {
        memset(s->sums, 0, (size_t)s->windows * WMR_WINDOW * sizeof(wmr_v));
    }
    w->findings[WMR_FOUND_FIRST_STEP] = w->findings[WMR_FOUND_LEFT_SAMPLE] = wmr_all(-1.0);
    w->findings[WMR_FOUND_MARGIN_V1] = w->findings[WMR_FOUND_MARGIN_OMEGA] = wmr_all(WMR_NO_MARGIN);
#ifdef WMR_FOUND_GAP
    w->findings[WMR_FOUND_GAP] = wmr_all(WMR_NO_MARGIN);
#endif
    w->running = wmr_always();
    monitor(w, w->running);
}

/* Two uniform numbers on [0, 1) for each lane. */
static void uniform_pair(const wmr_settings *s, const uint64_t counter[4], wmr_v u[2])
{
    for (int i = 0; i < WMR_WIDTH; ++i) {
        uint64_t words[4];
        wmr_philox(counter, s->key + 2 * i, words);
        WMR_AT(u[0], i) = (double)(int64_t)(words[0] >> 11) * WMR_2M53;
        WMR_AT(u[1], i) = (double)(int64_t)(words[1] >> 11) * WMR_2M53;
    }
}

/* Two independent standard normal numbers (Box-Muller); a pair beyond `most` is drawn again. */
static void normal_pair(const wmr_settings *s, uint64_t counter[4], wmr_v most, wmr_v out[2])
{
    wmr_m open = wmr_always();
    wmr_v u[2];
    out[0] = out[1] = wmr_all(0.0);
    for (counter[2] = 0; counter[2] < ATTEMPTS && wmr_some(open); ++counter[2]) {
        uniform_pair(s, counter, u);
        const wmr_v radius = wmr_sqrt(-2.0 * wmr_log(1.0 - u[0])), angle = TWO_PI * u[1];
        wmr_v sine, cosine;
        wmr_sin_cos(angle, &sine, &cosine);
        set(&out[0], open, radius * cosine);
        set(&out[1], open, radius * sine);
        open = open & (wmr_mask(wmr_abs(out[0]) > most) | wmr_mask(wmr_abs(out[1]) > most));
    }
    for (int i = 0; i < 2; ++i) {
        out[i] = wmr_max(-most, wmr_min(most, out[i]));
    }
}

/* All random numbers of one rate at sample or step `index`, in the order of the streams; those that
   are held over a sample only where `anew`, else they are in `out` already. */
static void draw(const wmr_settings *s, const wmr_loop *w, int per_step, int anew, int64_t index,
                 wmr_v *out)
{
    for (int k = 0; k < STREAM_COUNT; ++k) {
        const wmr_v *said = w->clock + WMR_CLOCK_STREAMS + 2 * k;
        if (STREAMS[k].per_step != per_step) {
            continue;
        }
        if (STREAMS[k].held && !anew) {
            out += 2 * STREAMS[k].pairs;
            continue;
        }
        const uint64_t at = (uint64_t)(STREAMS[k].held ? index / w->substeps : index);
        for (int pair = 0; pair < STREAMS[k].pairs; ++pair, out += 2) {
            uint64_t counter[4] = {at, STREAMS[k].number, 0, (uint64_t)pair};
            out[0] = out[1] = wmr_all(0.0);
            if (!wmr_some(wmr_truth(said[0]))) {
                continue;
            }
            if (STREAMS[k].normal) {
                normal_pair(s, counter, said[1], out);
            } else {
                uniform_pair(s, counter, out);
                out[0] = 2.0 * out[0] - 1.0;
                out[1] = 2.0 * out[1] - 1.0;
            }
        }
    }
}

/* The command that arrives at this plant step, in place of the one that is given. */
static void deliver(const wmr_settings *s, const wmr_loop *w, const wmr_v *command, wmr_v *arriving)
{
    if (w->delay_steps > 0) {
        wmr_v *slot = s->queue + 2 * (w->step % w->delay_steps);
        copy(arriving, slot, 2);
        copy(slot, command, 2);
    }
}

#ifndef WMR_OUTSIDE
static void move(wmr_v *state, wmr_m moving, const wmr_v *next)
{
#if WMR_WIDTH == 1
    (void)moving;
    copy(state, next, WMR_FAST);
#else
    for (int k = 0; k < WMR_FAST; ++k) {
        state[k] = wmr_choose(moving, next[k], state[k]);
    }
#endif
}

static void plant_steps(const wmr_settings *s, wmr_loop *w, const wmr_v *held)
{
    wmr_v u[WMR_HELD], next[WMR_FAST], draws[WMR_STEP_DRAWS + 1], *state = wmr_loop_state(w);
    copy(u, held, WMR_HELD);
    for (int64_t i = 0; i < w->substeps && wmr_some(w->running); ++i) {
        const wmr_m moving = w->running;
        const wmr_v index = wmr_all((double)w->step);
        change(s, w);
        deliver(s, w, held, u);
        if (WMR_STEP_DRAWS) {
            draw(s, w, 1, i == 0, w->step, draws);
        }
        wmr_step(&index, u, state, parameters(s, w), draws, w->prepared_step, next);
        move(state, moving, next);
        w->step += 1;
        monitor(w, moving);
    }
}

#ifdef WMR_SAMPLE_WATCHED_PREPARED
/* Adds this sample to the windows that it is in; behind the sums is how far it was off at most.  Of a
   window that a run does not last through nobody reads them. */
static void add_up(const wmr_settings *s, const wmr_loop *w, const wmr_v *seen)
{
    for (int64_t k = 0; k < s->windows; ++k) {
        if (w->sample >= s->window[2 * k] && w->sample < s->window[2 * k + 1]) {
            wmr_v *kept = s->sums + WMR_WINDOW * k, *most = kept + WMR_SUMS;
            for (int i = 0; i < WMR_SUMS; ++i) {
                kept[i] += seen[i];
            }
            set(most, wmr_mask(seen[0] > *most), seen[0]);
        }
    }
}

/* Records the guard's action, also that of an inactive guard, and whether the motion contradicts its bounds. */
static void watch(wmr_loop *w, const wmr_v *seen)
{
    wmr_v *found = w->findings, *peak = &found[WMR_FOUND_TORQUE];
    const wmr_v *least = seen + WMR_SEEN_LEAST1, *clip = seen + WMR_SEEN_CLIP1;
    const wmr_m linear = wmr_truth(seen[WMR_SEEN_BEYOND1]);
    const wmr_m either = linear | wmr_truth(seen[WMR_SEEN_BEYOND2]);
    const wmr_m first = w->running & either & wmr_mask(found[WMR_FOUND_LEFT_SAMPLE] < 0.0);
    set(&found[WMR_FOUND_LEFT_AXIS], first, wmr_choose(linear, wmr_all(1.0), wmr_all(2.0)));
    set(&found[WMR_FOUND_LEFT_SAMPLE], first, wmr_all((double)w->sample));
    for (int i = 0; i < 2; ++i) {
        wmr_v *most = &found[WMR_FOUND_D_LEAST1 + i];
        set(most, w->running & wmr_mask(least[i] > *most), least[i]);
        found[WMR_FOUND_CLIPPED1 + i] += wmr_number(w->running & wmr_truth(clip[i]));
    }
    set(peak, w->running & wmr_not(wmr_mask(seen[WMR_SEEN_PEAK] <= *peak)), seen[WMR_SEEN_PEAK]);
#ifdef WMR_FOUND_GAP
    set(&found[WMR_FOUND_GAP], w->running & wmr_mask(seen[WMR_SEEN_GAP] < found[WMR_FOUND_GAP]),
        seen[WMR_SEEN_GAP]);
#endif
}
#endif

/* From now on the slow part that a sample left is valid, with the unchanged fast part. */
static void take_on(wmr_loop *w)
{
#ifdef WMR_ONE_STATE
    copy(wmr_loop_state(w) + WMR_FAST, wmr_loop_next(w) + WMR_FAST, WMR_STATE - WMR_FAST);
#else
    copy(wmr_loop_next(w), wmr_loop_state(w), WMR_FAST);
    w->now = !w->now;
#endif
}

void wmr_loop_sample(const wmr_settings *s, wmr_loop *w, wmr_v *row)
{
    wmr_v held[WMR_HELD], draws[WMR_SAMPLE_DRAWS + 1];
    const wmr_v k = wmr_all((double)w->sample), *x = wmr_loop_state(w), *p;
    wmr_v *next = wmr_loop_next(w) + WMR_FAST;
    change(s, w);
    draw(s, w, 0, 1, w->sample, draws);
    p = parameters(s, w);
#ifdef WMR_SAMPLE_WATCHED_PREPARED
    if (!row) {
        wmr_v seen[WMR_SEEN];
        wmr_sample_watched(&k, x, p, draws, w->prepared_watched, next, held, seen);
        watch(w, seen);
        add_up(s, w, seen);
    } else
#endif
    {
        wmr_sample_logged(&k, x, p, draws, w->prepared_logged, next, held, row);
    }
    w->findings[WMR_FOUND_SAMPLES] += wmr_number(w->running);
    take_on(w);
    plant_steps(s, w, held);
    w->sample += 1;
}

/* Copies a row of all lanes to the log of each lane, with one kind of NaN. */
static void deal(double *const *log, int64_t sample, const wmr_v *row)
{
    for (int i = 0; i < WMR_WIDTH; ++i) {
        double *to = log[i] ? log[i] + sample * WMR_ROW : 0;
        for (int k = 0; to && k < WMR_ROW; ++k) {
            to[k] = WMR_AT(row[k], i) == WMR_AT(row[k], i) ? WMR_AT(row[k], i) : WMR_NAN;
        }
    }
}

int wmr_loop_run(const wmr_settings *s, wmr_loop *w)
{
    wmr_v row[WMR_ROW];
    wmr_loop_start(s, w);
    while (w->sample < s->samples && wmr_some(w->running) && !*s->cancelled) {
        const int64_t sample = w->sample;
        wmr_loop_sample(s, w, s->log ? row : 0);
        if (s->log) {
            deal(s->log, sample, row);
        }
    }
    return *s->cancelled != 0;
}
#endif
