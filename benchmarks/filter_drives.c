/* Drives of a base behind the filter's package, which is told limits and free distances, against an adversary.

   The base has a model of its own: tau v' = K u + d - v on both axes, integrated by exact exponentials between all
   instants at which something changes.  One with a ``decel`` follows K u + d at any rate, but slows down by at least
   ``decel``, and tau is the lag behind that.  Once commands of (0, 0) have acted for ``rest``, at the latest, it
   stands and holds.  Everything is drawn from the seed, unless a choice is given. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "wmr_filter.h"

#define MOST 2048  /* samples of a drive */
#define NEVER 1e18
#define FULL 1e3   /* a command beyond all limits */
#define SAME 1e-12 /* s: times nearer than this are one */
#define NEAR_BY 8192

/* limits: of v, of -v; decel: 0 of a base of first order. */
typedef struct { double tau[2], gain[2], push, odometry, limits[2], decel; } axis_numbers;
typedef struct {
    double period, jitter, delay[2], losses, age, rest, nearing, error, free_age, leave, heard, hold;
    axis_numbers axes[2];
} numbers; /* Base in filter_trials/stopping.py */

typedef struct {
    double seconds, axis, side, base, driver, limits, near, less, missing, rule, speed, rate, kept, far[2];
    double apart, pauses, trusts;
} choices; /* Choices there; -1: by chance */

enum { PRESS, ANY, TO_AND_FRO, ON_AND_OFF, ODD, TURN_BACK, SMALL, BACK, TAPS, ALL_SORTS, SLOWLY, ONE_STEP, DRIVERS };
enum { GREEDY, DRAWN, SWITCHING, EXTREMES, BASES };
enum { CONSTANT, KEPT, NOISY, FALLING, BROKEN, LIMITS };
enum { FILTER, APPROACH, ROOT };

typedef struct {
    double over;    /* largest |v| of a limit that does not change; a command that is no number: NEVER */
    double gap;     /* least gap [m, rad] while moving towards what is in the way, until the first touch */
    double late;    /* largest excess over a lowered limit [m/s, rad/s] after its time */
    double used;    /* largest share of that time */
    double waits;   /* most steps for which a request straight away waited, as a share of what is promised */
    double stopped; /* gap at the end */
    double mean;    /* mean |v| */
    double passed;  /* requests that passed after they were refused */
    double early;   /* releases that came too early */
    double drawn;   /* number of the adversary */
} result;

static uint64_t mixed(uint64_t *s)
{
    uint64_t z = (*s += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

static double uniform(uint64_t *s, double low, double high)
{
    return low + (high - low) * (double)(mixed(s) >> 11) * 0x1p-53;
}

static int below(uint64_t *s, int n) { return (int)(mixed(s) % (uint64_t)n); }
static int chance(uint64_t *s, double share) { return uniform(s, 0, 1) < share; }
static double either(uint64_t *s, double size) { return below(s, 2) ? size : -size; }
static int chosen(uint64_t *s, double given, int n) { int drawn = below(s, n); return given < 0 ? drawn : (int)given; }
static double larger(double a, double b) { return a > b ? a : b; }
static double smaller(double a, double b) { return a < b ? a : b; }

/* Way for each m/s of a speed that fades for a time. */
static double covered(double time, double tau) { return isfinite(time) ? -tau * expm1(-time / tau) : tau; }

/* Time from the step that receives a limit V until the base is within it, if its speed was at most v_0. */
static double inside_by(const numbers *p, const axis_numbers *a, double v_0, double V)
{
    double shortest = (1 - p->jitter) * p->period, longest = (1 + p->jitter) * p->period;
    double spread = p->delay[1] - p->delay[0], least = larger(0, shortest - spread);
    double first = p->delay[1] + p->losses * longest;
    if (v_0 <= V) return first;
    if (V <= a->push || a->decel > 0) return NEVER; /* a clip promises no time */
    double fades = a->tau[1] * log((v_0 - a->push) / (V - a->push)), n = ceil((fades + spread) / shortest - 1e-9);
    return first + smaller(fades + least, (n + p->losses) * longest);
}

static double roll_of(const numbers *p, const axis_numbers *a)
{
    return a->push > 0 ? a->push * (p->rest - (a->decel > 0 ? 0 : covered(p->rest, a->tau[0]))) : 0;
}

/* Least steady speed away that a command causes; V: limit of that side. */
static double pull_of(const axis_numbers *a, double u, double V)
{
    return a->gain[0] * smaller(fabs(u), (V - a->push) / a->gain[1]) - a->push;
}

static double hold_of(const numbers *p, const axis_numbers *a, double pull)
{
    if (pull <= 1e-9) return NEVER;
    double time = roll_of(p, a) / pull + a->tau[1] - covered(p->rest, a->tau[0]) + p->delay[1] - p->delay[0];
    return p->losses + ceil(time / ((1 - p->jitter) * p->period) - 1e-9);
}

static double zeros_until_rest(const numbers *p)
{
    double spread = p->delay[1] - p->delay[0], longest = (1 + p->jitter) * p->period;
    return ceil((spread + p->losses * longest + p->rest) / ((1 - p->jitter) * p->period) + 1e-9);
}

/* nav2's approach rule by its parameters: the command is scaled by the time until it would touch over the horizon. */
static double approach(double distance, double asked, double horizon)
{
    double step = 0.1;
    for (int k = 0; k * step <= horizon; ++k)
        if ((k + 1) * step * asked >= distance) return asked * k * step / horizon;
    return asked;
}

/* A limit of one side that was told, and since when the base has to be inside. */
typedef struct { double limit, before, told, due; } deadline;

/* Requests away from one side: commands sent in a row, their least pull, releases that came too early. */
typedef struct { int sent, spent, refused, waited; double weakest; } request;

typedef struct { double t, v[2], free[2][2], sent[2], take[2]; } sample;

typedef struct {
    const numbers *p, *real; /* bounds given to the filter, and true values */
    const choices *c;
    result *out;
    uint64_t seed;
    int axis, side, base, driver, limits, noise, delays, losing, jitter, other; /* how the adversary chooses */
    double t, x[2], v[2], walls[2][2]; /* walls: places ahead and behind of which the base touches */
    double tau[2], gain[2], push[2], nearing[2], zero_since, brakes_after;
    double ramped[2], ends[2], rates[2][2]; /* ramp of a base that slows down: value, target, rates of fall and rise */
    int touched[2][2], braked;
    int blind; /* a distance is missing in this step: a request may wait until all come */
    double asked, across, away, leaves_late, stands_after, left_at; /* asked: away from the wall is below 0 */
    int left, turns_at, waiting, left_since;
    double ceiling[2][2];
    int phase, changed;
    deadline due[2][2];
    double off[2], error[2], elapsed;
    request requests[2][2];
    int owed, owing[2];
    double owed_command;
    int acting[2], lost;
    double last_take[2], last_heard[2];
    wmr_filter_parameters parameters;
    wmr_filter_state state;
    sample samples[MOST];
} drive;

/* Speed and position of one axis after a time without changes, in which its ramp rises by ``rate`` (0: is constant). */
static void later(const drive *s, int i, double h, double rate, double *v, double *x)
{
    double tau = s->tau[i], m = s->ramped[i], end = rate == 0 ? m : s->ends[i];
    if (tau <= 0) {
        *v = m + rate * h;
        *x = s->x[i] + (m + rate * h / 2) * h;
    } else {
        double m_0 = m - rate * tau, fades = -expm1(-h / tau), away = s->v[i] - m_0;
        *v = s->v[i] + (m_0 - s->v[i]) * fades + rate * h;
        *x = s->x[i] + m_0 * h + away * tau * fades + rate * h * h / 2;
    }
    double before = tau > 0 ? s->v[i] : m; /* rounding must not exceed the base's real motion */
    *v = larger(smaller(*v, larger(larger(before, m), end)), smaller(smaller(before, m), end));
}

/* The time at which a speed of one axis passes one that it has not yet. */
static double reaches(const drive *s, int i, double h, double rate, double speed)
{
    double tau = s->tau[i], m = s->ramped[i], v, x, low = 0, high = h;
    if (rate == 0 && tau > 0) return tau * log((s->v[i] - m) / (speed - m));
    for (int k = 0; k < 60; ++k) {
        double middle = (low + high) / 2;
        later(s, i, middle, rate, &v, &x);
        if ((v < speed) == (s->v[i] < speed)) low = middle;
        else high = middle;
    }
    return high;
}

/* One axis over a piece of time in which nothing changes. */
static void carried_on(drive *s, int i, double h, double rate)
{
    double v = s->v[i], x = s->x[i], after, far, at, speed_there;
    later(s, i, h, rate, &after, &far);
    if (s->braked) { after = v = 0; far = x; }
    double turns = v * after < 0 ? reaches(s, i, h, rate, 0) : h; /* until it stands for a moment */
    for (int k = 0; k < 2; ++k) {
        double way = k ? -1 : 1, before = way * v, then = way * after, most = larger(before, then);
        double speed = i == 0 ? s->nearing[k] : 0, wall = s->walls[i][k];
        if (most > 0) s->out->over = larger(s->out->over, most / s->p->axes[i].limits[k]);
        if (!s->touched[i][k] && most > 0) {
            double until = before > 0 ? turns : h;
            later(s, i, until, rate, &speed_there, &at);
            s->out->gap = smaller(s->out->gap, wall - speed * until - way * (s->braked ? x : at));
        }
        s->walls[i][k] = wall - speed * h;
        if (s->walls[i][k] < way * far) s->touched[i][k] = 1;
        deadline *d = &s->due[i][k];
        if (s->t + h >= d->due) s->out->late = larger(s->out->late, (s->t >= d->due ? most : then) - d->limit);
        if (d->due < NEVER && d->before > d->limit && before > d->limit) {
            double until = then > d->limit ? h : reaches(s, i, h, rate, way * d->limit);
            double promised = d->due - d->told + s->c->less * s->p->period;
            s->out->used = larger(s->out->used, (s->t + until - d->told) / promised);
        }
    }
    s->x[i] = far;
    s->v[i] = after;
    s->ramped[i] = s->braked ? 0 : s->ramped[i] + rate * h;
}

/* The same until commands change, or the ramp of a base that slows down comes to its end or to 0. */
static void carried(drive *s, int i, double h, double u)
{
    double m = s->gain[i] * u + s->push[i], r = s->ramped[i], rate = s->rates[i][m > r];
    s->ends[i] = m;
    if (s->real->axes[i].decel <= 0 || s->braked || rate >= NEVER || fabs(m - r) < SAME) r = s->ramped[i] = m;
    carried_on(s, i, h, r == m ? 0 : m > r ? rate : -rate);
}

/* Time until the ramp of a base that slows down comes to its end or to 0. */
static double ramp_lasts(const drive *s, int i, double u)
{
    double m = s->gain[i] * u + s->push[i], r = s->ramped[i], rate = s->rates[i][m > r];
    if (s->real->axes[i].decel <= 0 || s->braked || rate >= NEVER || fabs(m - r) < SAME) return NEVER;
    return fabs((r * m < 0 && fabs(r) > SAME ? 0 : m) - r) / rate;
}

static void base_chooses(drive *s, int i, double u)
{
    const axis_numbers *a = &s->real->axes[i];
    double way = i == s->axis || s->base != GREEDY ? s->side : (s->seed & 1 ? 1 : -1);
    if (s->base == GREEDY) {
        s->gain[i] = way * u > 0 ? a->gain[1] : a->gain[0];
        s->push[i] = way * a->push;
        s->tau[i] = way * (s->gain[i] * u + s->push[i]) > way * s->v[i] ? a->tau[0] : a->tau[1];
    } else if (s->base == SWITCHING && chance(&s->seed, 0.2)) {
        s->tau[i] = uniform(&s->seed, a->tau[0], a->tau[1]);
        s->gain[i] = uniform(&s->seed, a->gain[0], a->gain[1]);
        s->push[i] = uniform(&s->seed, -a->push, a->push);
    } else if (s->base == EXTREMES && chance(&s->seed, 0.2)) {
        s->tau[i] = a->tau[below(&s->seed, 2)];
        s->gain[i] = a->gain[below(&s->seed, 2)];
        s->push[i] = either(&s->seed, a->push);
    }
    if (a->decel <= 0) return;
    for (int up = 0; up < 2; ++up) {
        int slows = (s->ramped[i] > 0) != up, towards = (way > 0) == up;
        if (s->base == GREEDY) s->rates[i][up] = towards ? NEVER : a->decel;
        else if (s->base != DRAWN || s->rates[i][up] == 0)
            s->rates[i][up] = below(&s->seed, 2) ? a->decel : slows ? uniform(&s->seed, 1, 5) * a->decel : NEVER;
        if (slows) s->rates[i][up] = larger(s->rates[i][up], a->decel);
    }
}

/* What the driver asks for next. */
static void asks(drive *s, int k, int stands)
{
    static const double some[] = {FULL, -FULL, 0, 1e-3, -1e-3, 0.05, -0.05, 1e-12, -1e-12, 0.3, -0.3};
    uint64_t *r = &s->seed;
    double T = s->p->period, t = k * T;
    int near = s->c->near > 0, c;
    switch (s->driver) {
    case PRESS: s->asked = FULL; break;
    case ANY: if (chance(r, 0.05)) s->asked = uniform(r, -1.5, 1.5); break;
    case TO_AND_FRO: if (chance(r, 0.1)) s->asked = chance(r, 0.6) ? FULL : -FULL; break;
    case ON_AND_OFF: s->asked = (k / 15) % 2 ? 0 : FULL; break;
    case ODD: if (chance(r, 0.3)) s->asked = some[below(r, 11)]; break;
    case TURN_BACK: s->asked = k < s->turns_at ? FULL : -FULL; break;
    case SMALL: if (chance(r, 0.5)) s->asked = uniform(r, -0.2, 0.2); break;
    default:
        if (s->left > 0) { --s->left; break; }
        if (s->driver == BACK) s->asked = t > 8 || near ? -s->away : FULL;
        else if ((s->driver == TAPS || s->driver == ONE_STEP) && !near && t < 6) s->asked = FULL;
        else if (s->driver == TAPS) {
            int ends = s->asked < 0;
            s->asked = ends ? 0 : -s->away;
            s->left = ends ? below(r, (int)(1.5 * smaller(s->p->rest, 1) / T) + 1) : below(r, 6);
        } else if (s->driver == ONE_STEP) s->asked = stands && s->asked >= 0 ? -s->away : 0;
        else if (s->driver == SLOWLY) { s->asked = s->asked > 0 ? -s->away : FULL; s->left = 100; }
        else {
            c = below(r, 8);
            s->asked = c < 2 ? FULL : c < 5 ? -s->away : c == 5 ? 0 : c == 6 ? uniform(r, -0.3, 0.3)
                     : either(r, below(r, 2) ? 1e-3 : 0.06);
            s->left = below(r, 40);
        }
    }
    const double *limits = s->p->axes[1 - s->axis].limits;
    double V = smaller(limits[0], limits[1]);
    switch (s->other) {
    case 0: s->across = 0; break;
    case 1: if (k == 0) s->across = uniform(r, -V, V); break;
    case 2: if (chance(r, 0.1)) s->across = uniform(r, -1.5 * V, 1.5 * V); break;
    case 3: if (chance(r, 0.1)) s->across = chance(r, 0.5) ? 0 : either(r, FULL); break;
    default: s->across = s->asked == 0 ? 0 : either(r, 1e-3);
    }
    if (t >= s->leaves_late) { s->asked = -s->away; s->across = 0; }
}

static void begins(drive *s)
{
    uint64_t *r = &s->seed;
    const choices *c = s->c;
    const numbers *p = s->p;
    for (int k = 0; k < 4; ++k) mixed(r);
    s->axis = c->axis < 0 ? below(r, 4) == 0 : (int)c->axis;
    s->side = chosen(r, c->side, 2) ? -1 : 1;
    s->base = chosen(r, c->base, BASES);
    s->driver = chosen(r, c->driver, DRIVERS);
    s->limits = chosen(r, c->limits, LIMITS);
    s->noise = below(r, 3);
    s->delays = below(r, 6);
    s->losing = below(r, 2);
    s->jitter = below(r, 4);
    s->other = s->base == GREEDY && c->driver >= 0 && c->driver < BACK ? 0 : below(r, 3) ? below(r, 5) : 0;
    if (s->base == GREEDY && chance(r, 0.7)) { s->noise = 0; s->delays = 1; s->losing = 1; s->jitter = 1; }
    s->out->drawn = s->driver + 100 * s->base + 1000 * s->limits + 10000 * s->delays + 100000 * s->axis;
    s->leaves_late = s->driver >= BACK && !c->rule ? c->seconds - 12 : NEVER;
    s->stands_after = isfinite(p->rest) ? zeros_until_rest(p) : NEVER;
    const axis_numbers *mine = &p->axes[s->axis];
    s->away = below(r, 2) ? FULL : 2.5 * mine->push / mine->gain[0] + uniform(r, 0, 0.3);
    if (s->away <= 0) s->away = 0.1;
    s->turns_at = 40 + below(r, 60);
    if (s->driver == ALL_SORTS || s->driver == SLOWLY) s->asked = -1;

    int near = s->side > 0 ? 0 : 1;
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 2; ++k) s->walls[i][k] = NEVER;
    if (c->far[1] > 0) {
        double *walls = s->walls[s->axis];
        walls[near] = uniform(r, c->far[0], c->far[1]);
        walls[1 - near] = s->driver < BACK ? uniform(r, c->far[0], c->far[1]) : s->axis ? NEVER : 40;
        if (c->near > 0) walls[near] = p->leave * roll_of(p, mine) + (below(r, 2) ? 0 : uniform(r, 0, 0.1));
        else if (s->axis == 0 && s->driver < BACK && !c->rule && chance(r, 0.3)) /* angles as well */
            for (int k = 0; k < 2; ++k) s->walls[1][k] = uniform(r, 0, 3);
    }
    s->braked = isfinite(s->real->rest) && (c->far[1] > 0 || chance(r, 0.7));
    for (int i = 0; i < 2; ++i) {
        const axis_numbers *a = &s->real->axes[i], *b = &p->axes[i];
        s->tau[i] = uniform(r, a->tau[0], a->tau[1]);
        s->gain[i] = uniform(r, a->gain[0], a->gain[1]);
        s->push[i] = uniform(r, -a->push, a->push);
        s->v[i] = s->braked || c->far[1] > 0 ? 0 : uniform(r, -b->limits[1], b->limits[0]);
        s->ramped[i] = s->v[i];
        s->acting[i] = -1;
        s->last_take[i] = s->last_heard[i] = -NEVER;
        for (int k = 0; k < 2; ++k) {
            s->due[i][k] = (deadline){b->limits[k], b->limits[k], 0, 0};
            s->ceiling[i][k] = b->limits[k];
            s->requests[i][k].weakest = NEVER;
            if (s->walls[i][k] < p->leave * roll_of(p, b)) /* nearer than the filter would have stopped it */
                s->requests[i][k].spent = (int)p->leave;
        }
    }
    s->brakes_after = s->real->rest;
    s->left_at = NEVER;
}

/* Limits of this step; they change in phases, within each of which they are at most its ceilings. */
static void tell_limits(drive *s, int k, wmr_filter_inputs *u)
{
    uint64_t *r = &s->seed;
    const numbers *p = s->p;
    const axis_numbers *mine = &p->axes[s->axis];
    int last = k * p->period >= s->leaves_late - 2, changes = 0;
    if (last && s->limits != CONSTANT) { /* the last request is made within the widest limits */
        changes = 1;
        s->limits = CONSTANT;
    } else if (s->limits != CONSTANT && s->phase-- <= 0 && s->owed == 0) {
        changes = k > 0;
        s->phase = k == 0 ? 40 + below(r, 60)
                 : s->limits == KEPT ? 30 + below(r, (int)(6 * mine->tau[1] / p->period) + 60) : below(r, 40);
        for (int i = 0; i < 2; ++i)
            for (int m = 0; m < 2; ++m) {
                double V = p->axes[i].limits[m], push = p->axes[i].push, share = uniform(r, 0, 1);
                if (below(r, 3)) share *= share;
                s->ceiling[i][m] = k == 0 && chance(r, 0.7) ? V : push + (V - push) * share;
                if (s->limits >= NOISY && chance(r, 0.1)) s->ceiling[i][m] = 0;
            }
    }
    s->changed = changes ? 20 : s->changed - 1;
    for (int i = 0; i < 2; ++i)
        for (int m = 0; m < 2; ++m) {
            const axis_numbers *a = &p->axes[i];
            deadline *e = &s->due[i][m];
            if (last) s->ceiling[i][m] = a->limits[m];
            double told = s->ceiling[i][m];
            if (changes) {
                double from = s->t >= e->due ? e->limit : larger(e->limit, e->before);
                double to = smaller(larger(told, a->push), a->limits[m]), lasts = inside_by(p, a, from, to);
                *e = (deadline){to, from, s->t, lasts >= NEVER ? NEVER : s->t + lasts - s->c->less * p->period};
            }
            if (s->owed == 0) {
                if (s->limits == NOISY) told *= uniform(r, 0.9, 1);
                if (s->limits == FALLING) told *= larger(0, 1 - 0.01 * (k % 100));
                if (s->limits == BROKEN && chance(r, 0.05)) told = below(r, 2) ? NAN : uniform(r, -1, 0);
            }
            if (s->limits == CONSTANT && below(r, 2)) told = INFINITY;
            u->limits[2 * i + 1 - m] = m ? -told : told;
        }
}

/* Odometry and free distances of this step, as old as they may be, and off by at most their errors. */
static void tell_measured(drive *s, int k, wmr_filter_inputs *u)
{
    uint64_t *r = &s->seed;
    const numbers *p = s->p, *real = s->real;
    sample *now = &s->samples[k];
    now->t = s->t;
    for (int i = 0; i < 2; ++i) {
        double n = real->axes[i].odometry, way = i == s->axis ? s->side : 1;
        if (s->noise == 0) s->off[i] = -way * n;
        else if (s->noise == 1) s->off[i] = uniform(r, -n, n);
        else if (k % 7 == 0) s->off[i] = either(r, n);
        now->v[i] = s->v[i];
        for (int m = 0; m < 2; ++m) {
            if (s->noise == 0) s->error[m] = real->error;
            else if (s->noise == 1) s->error[m] = uniform(r, -real->error, real->error);
            else if (k % 7 == 0) s->error[m] = either(r, real->error);
            now->free[i][m] = s->walls[i][m] - (m ? -s->x[i] : s->x[i]);
        }
    }
    int aged = (int)(real->age / p->period + 1e-9), ago = k - (s->noise == 0 ? aged : below(r, aged + 1));
    while (ago < k && (ago < 0 || s->t - s->samples[ago].t > real->age + SAME)) ++ago;
    int heard = p->heard > 0 && (s->noise != 2 || chance(r, 0.7));
    u->odometry_age = heard ? smaller(s->t - s->samples[ago].t, p->age) : -1;
    for (int i = 0; i < 2; ++i) u->v_odometry[i] = s->samples[ago].v[i] + s->off[i];
    if (s->noise == 2 && chance(r, 0.01)) u->v_odometry[below(r, 2)] = NAN;

    int back = (int)(real->free_age / p->period + 1e-9), source = k - (s->noise == 0 ? back : below(r, back + 1));
    while (source < k && source >= 0 && s->t - s->samples[source].t > real->free_age + SAME) ++source;
    int seen = source >= 0 && (k == back || !chance(r, s->c->missing));
    s->blind = !seen;
    u->free_age = seen ? smaller(s->t - s->samples[source].t, p->free_age) : -1;
    for (int i = 0; i < 2; ++i)
        for (int m = 0; m < 2; ++m) {
            double far = seen ? s->samples[source].free[i][m] + (i ? 0 : s->error[m]) : NAN;
            if (s->c->missing > 0 && chance(r, 0.05)) far = NAN;
            s->blind |= isnan(far);
            u->free[2 * i + m] = far > 1e9 ? INFINITY : far;
        }
}

/* Command of another rule, on the axis that is tried. */
static double ruled(const drive *s, double distance)
{
    double asked = smaller(s->asked, s->c->speed), rate = s->c->rate;
    distance = larger(distance, 0);
    if (asked <= 0) return asked;
    if (s->c->rule == APPROACH) return approach(distance, asked, rate);
    return smaller(asked, sqrt(2 * rate * larger(0, distance - s->c->kept)));
}

/* Obligation of the driver after a step: no early release of a command that passed by holding. */
static void count_requests(drive *s, const wmr_filter_inputs *u, const double sent[2], int near_by, int stands)
{
    const numbers *p = s->p;
    for (int i = 0; i < 2; ++i)
        for (int m = 0; m < 2; ++m) {
            const axis_numbers *a = &p->axes[i];
            request *e = &s->requests[i][m];
            double way = m ? 1 : -1, told = way * u->limits[2 * i + m];
            double V = larger(a->push, smaller(isnan(told) ? 0 : told, a->limits[1 - m]));
            double pull = pull_of(a, sent[i], V), hold = hold_of(p, a, pull);
            int mine = s->owing[0] == i && s->owing[1] == m;
            if (way * sent[i] > 0) {
                e->weakest = e->sent == 0 ? pull : smaller(e->weakest, pull);
                ++e->sent;
                s->out->passed += e->refused;
                int opened = e->refused && s->walls[i][m] < 1e9 && sent[1 - i] == 0 && a->push > 0;
                if (a->decel <= 0 && opened && e->spent >= p->leave && hold < NEVER) {
                    s->owed = (s->c->trusts > 0 ? e->waited : (int)hold) - 1; /* trusts: as long as it waited */
                    s->owing[0] = i;
                    s->owing[1] = m;
                    s->owed_command = fabs(u->v_asked[i]);
                }
            } else if (e->sent > 0) {
                int early = e->sent < hold_of(p, a, e->weakest);
                e->spent += early;
                s->out->early += early;
                e->sent = 0;
                if (mine) s->owed = 0;
            }
            e->refused = near_by && way * u->v_asked[i] > 0 && sent[i] == 0;
            e->waited = e->refused && stands ? e->waited + 1 : 0;
        }
}

/* Steps for which the last request waits, as a share of what is promised; it has to lead away in the end. */
static void count_waiting(drive *s, int k, int goes)
{
    const numbers *p = s->p;
    const axis_numbers *a = &p->axes[s->axis];
    int behind = s->side > 0 ? 1 : 0, last = k + 1 == (int)(s->c->seconds / p->period);
    double pull = pull_of(a, s->away, a->limits[behind]), place = s->side * s->x[s->axis];
    double most = (s->stands_after < NEVER ? s->stands_after : 0) + hold_of(p, a, pull) + 2;
    if (a->decel > 0) return; /* it promises none */
    if (!(pull > 1e-9 && s->walls[s->axis][behind] + place > 5 && p->nearing == 0)) return;
    if (s->owed > 0) s->left_at = NEVER; /* until then the driver keeps to an earlier request */
    else if (s->left_at == NEVER) { s->left_at = place; s->left_since = k; }
    else s->left_at = larger(s->left_at, place); /* where it turned */
    int long_ago = s->owed == 0 && (k - s->left_since) * p->period > 9 && most * p->period < 6;
    if (last && long_ago && pull > 0.02 && place > s->left_at - 0.05) s->out->waits = NEVER;
    if (s->waiting >= 0 && s->owed == 0) ++s->waiting;
    if (goes) s->waiting = -1;
    if (!s->blind) s->out->waits = larger(s->out->waits, s->waiting / most);
}

/* One command: 1 if no side was open for it. */
static int commands(drive *s, int k, wmr_filter_inputs *u, double sent[2])
{
    wmr_filter_outputs y;
    if (s->c->rule) {
        sent[s->axis] = s->side * ruled(s, u->free[s->side > 0 ? 0 : 1]);
        sent[1 - s->axis] = 0;
        return 0;
    }
    int spent = 0;
    for (int i = 0; i < 2; ++i) for (int m = 0; m < 2; ++m) spent += s->requests[i][m].spent;
    if (spent > 0) { /* is every side open? */
        wmr_filter_state tried = s->state;
        wmr_filter_inputs none = *u;
        none.v_asked[0] = none.v_asked[1] = 0;
        wmr_filter_step(&s->parameters, &tried, &none, &y);
        if (!((long)y.filter_flags & NEAR_BY))
            for (int i = 0; i < 2; ++i) for (int m = 0; m < 2; ++m) s->requests[i][m].spent = 0;
    }
    wmr_filter_step(&s->parameters, &s->state, u, &y);
    for (int i = 0; i < 2; ++i) sent[i] = y.v_sent[i];
    if (!(isfinite(sent[0]) && isfinite(sent[1]))) s->out->over = NEVER;
    (void)k; /* trace */
    return ((long)y.filter_flags & NEAR_BY) != 0;
}

/* When a command takes over on each axis; a lost one never does. */
static void deliver(drive *s, int k)
{
    uint64_t *r = &s->seed;
    sample *now = &s->samples[k];
    double towards = s->side * now->sent[s->axis], old = k ? s->side * s->samples[k - 1].sent[s->axis] : 0;
    double low = s->real->delay[0], high = s->real->delay[1], delay[2];
    switch (s->delays) {
    case 0: delay[0] = uniform(r, low, high); break;
    case 1: delay[0] = towards > old ? low : high; break;
    case 2: delay[0] = towards < 0 ? high : low; break; /* taps are as short as they can be */
    case 3: delay[0] = (k + s->axis) % 2 ? low : high; break;
    case 4: delay[0] = s->changed > 0 ? high : low; break;
    default: delay[0] = below(r, 2) ? low : high;
    }
    delay[1] = s->c->apart > 0 ? uniform(r, low, high) : delay[0];
    int wish = s->losing ? towards < old || s->changed == 20 : chance(r, 0.4);
    s->lost = s->lost < s->real->losses && wish ? s->lost + 1 : 0;
    for (int i = 0; i < 2; ++i)
        now->take[i] = s->lost ? NEVER : (s->last_take[i] = larger(s->t + delay[i], s->last_take[i]));
}

/* Time until the next sample, and what the filter is told of it. */
static double lasts(drive *s, int k, int *zeros)
{
    uint64_t *r = &s->seed;
    double T = s->p->period, most = s->p->jitter, towards = s->side * s->samples[k].sent[s->axis];
    double j = s->jitter == 0 ? uniform(r, -1, 1) : s->jitter == 2 ? either(r, 1) : 1;
    if (s->jitter == 3 && towards < 0) j = -1;
    double share = 1 + s->real->jitter * j;
    s->elapsed = T * larger(1 - most, smaller(1 + most, share));
    if (s->c->pauses <= 0 || s->owed > 0 || s->driver >= BACK || !chance(r, s->c->pauses)) return T * share;
    *zeros = 0; /* the program stops for a while */
    return s->elapsed = T * (share + uniform(r, 0, 30));
}

/* The base until the next sample. */
static void moves(drive *s, int k, double dt)
{
    uint64_t *r = &s->seed;
    const numbers *real = s->real;
    int pieces = s->base == GREEDY ? 2 : 4;
    double begin = s->t, end = begin + dt;
    for (int m = 0; m < 2; ++m) s->nearing[m] = real->nearing * (s->base == GREEDY ? 1 : uniform(r, 0, 1));
    for (int piece = 1; s->t < end - SAME;) {
        double u[2], stop = end;
        while (piece < pieces && begin + dt * piece / pieces <= s->t + SAME) ++piece;
        if (piece < pieces) stop = begin + dt * piece / pieces;
        for (int i = 0; i < 2; ++i) {
            for (int m = s->acting[i] + 1; m <= k; ++m) { /* earlier commands were lost or replaced */
                double take = s->samples[m].take[i];
                if (take <= s->t + SAME) { s->acting[i] = m; s->last_heard[i] = take; }
                else stop = smaller(stop, take);
            }
            double ends = real->hold > 0 ? s->last_heard[i] + real->hold : NEVER;
            if (ends > s->t + SAME) stop = smaller(stop, ends);
            u[i] = s->acting[i] < 0 || ends <= s->t + SAME ? 0 : s->samples[s->acting[i]].sent[i];
            for (int m = 0; m < 2; ++m) if (s->due[i][m].due > s->t + SAME) stop = smaller(stop, s->due[i][m].due);
        }
        if (u[0] != 0 || u[1] != 0) { s->braked = 0; s->zero_since = NEVER; }
        else if (s->zero_since >= NEVER) {
            s->zero_since = s->t;
            s->brakes_after = real->rest * (s->base == GREEDY || below(r, 2) ? 1 : uniform(r, 0, 1));
        }
        double closes = s->zero_since < NEVER ? s->zero_since + s->brakes_after : NEVER;
        if (!s->braked && s->t >= closes - SAME) { s->braked = 1; s->v[0] = s->v[1] = 0; }
        if (!s->braked) stop = smaller(stop, closes);
        for (int i = 0; i < 2; ++i) {
            base_chooses(s, i, u[i]);
            stop = smaller(stop, s->t + ramp_lasts(s, i, u[i]));
        }
        for (int i = 0; i < 2; ++i) carried(s, i, stop - s->t, u[i]);
        s->out->mean += fabs(s->v[s->axis]) * (stop - s->t);
        s->t = stop;
    }
}

static void drive_one(const numbers *p, const numbers *real, const choices *c, uint64_t seed, result *out)
{
    drive s = {.p = p, .real = real, .c = c, .out = out, .seed = seed};
    wmr_filter_inputs u;
    *out = (result){.gap = NEVER, .late = -NEVER};
    memset(&u, 0, sizeof u);
    wmr_filter_defaults(&s.parameters);
    wmr_filter_start(&s.state);
    begins(&s);
    int n = (int)(c->seconds / p->period), zeros = 0;
    for (int k = 0; k < n && k < MOST; ++k) {
        double *sent = s.samples[k].sent;
        if (s.driver < BACK && !c->rule && s.base != GREEDY && chance(&s.seed, 0.01)) /* things go away */
            s.walls[s.axis][below(&s.seed, 2)] += uniform(&s.seed, 0, 2);
        tell_limits(&s, k, &u);
        tell_measured(&s, k, &u);
        int stands = zeros > s.stands_after;
        asks(&s, k, stands);
        u.v_asked[s.axis] = s.side * s.asked;
        u.v_asked[1 - s.axis] = s.across;
        if (s.owed > 0) { /* the driver goes on */
            int i = s.owing[0], way = s.owing[1] ? 1 : -1;
            --s.owed;
            u.v_asked[i] = way * larger(way * u.v_asked[i], s.owed_command);
            u.v_asked[1 - i] = 0;
        } else if (s.noise == 2 && k * p->period < s.leaves_late && chance(&s.seed, 0.002))
            u.v_asked[below(&s.seed, 2)] = NAN;
        u.elapsed = s.elapsed;
        int near_by = commands(&s, k, &u, sent);
        count_requests(&s, &u, sent, near_by, stands);
        if (k * p->period >= s.leaves_late) count_waiting(&s, k, s.side * sent[s.axis] < 0);
        zeros = sent[0] == 0 && sent[1] == 0 ? zeros + 1 : 0;
        deliver(&s, k);
        moves(&s, k, lasts(&s, k, &zeros));
    }
    out->mean /= s.t;
    out->stopped = s.walls[s.axis][s.side > 0 ? 0 : 1] - s.side * s.x[s.axis];
}

/* ``count`` drives, with seeds from ``seed`` on. */
void wmr_filter_drives(const double *told, const double *real, const double *chosen_ones, long count,
                       unsigned long long seed, double *out)
{
    for (long k = 0; k < count; ++k) {
        uint64_t own = seed + (uint64_t)k;
        drive_one((const numbers *)told, (const numbers *)real, (const choices *)chosen_ones, mixed(&own),
                  (result *)out + k);
    }
}
