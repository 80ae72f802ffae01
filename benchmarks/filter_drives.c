/* Drives of a base behind the filter's package, which is told limits and free ways, against an adversary.

   The base has a model of its own: tau v' = K u + d - v on both axes, integrated by exact exponentials between all
   instants at which something changes.  Once commands of (0, 0) have acted for ``rest``, at the latest, it stands and
   holds.  Everything is drawn from the seed, unless a choice is given. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "wmr_filter.h"

#define MOST 4096  /* samples of a drive */
#define NEVER 1e18
#define FULL 1e3   /* a command beyond all limits */
#define SAME 1e-12 /* s: times nearer than this are one */
#define NEAR_BY 8192

typedef struct { double tau[2], gain[2], push, odometry, limits[2]; } axis_numbers; /* limits: of v, of -v */
typedef struct {
    double period, jitter, delay[2], losses, age, rest, nearing, error, free_age, leave, heard, hold;
    axis_numbers axes[2];
} numbers; /* NUMBERS in filter_trials/stopping.py */

typedef struct {
    double seconds, axis, side, base, driver, limits, start, less, missing, rule, rule_numbers[3], far[2], apart, pauses;
} choices; /* CHOICES there; -1: by chance */

enum { PRESS, ANY, TO_AND_FRO, ON_AND_OFF, ODD, TURN_BACK, SMALL, BACK, TAPS, ALL_SORTS, SLOWLY, ONE_STEP, DRIVERS };
enum { GREEDY, DRAWN, SWITCHING, EXTREMES, BASES };
enum { CONSTANT, KEPT, NOISY, FALLING, BROKEN, LIMITS };
enum { FILTER, APPROACH, ROOT };

typedef struct {
    double over;     /* largest |v| of a limit that does not change, and largest command that is no number */
    double gap;      /* least gap [m, rad] while moving towards what is in the way, until the first touch */
    double late;     /* largest excess over a lowered limit [m/s, rad/s] after its time */
    double used;     /* largest share of that time */
    double waits;    /* most commands of a request straight away that were refused, as a share of what is promised */
    double stopped;  /* gap where the base first stood for long near the thing; -1 if nowhere */
    double mean;     /* mean |v| */
    double holds;    /* requests that passed after they were refused */
    double early;    /* releases that came too early */
    double shapes;   /* which adversary it was */
} result;

static uint64_t mixed(uint64_t *s)
{
    uint64_t z = (*s += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

static double uniform(uint64_t *s, double low, double high) { return low + (high - low) * (double)(mixed(s) >> 11) * 0x1p-53; }
static int below(uint64_t *s, int n) { return (int)(mixed(s) % (uint64_t)n); }
static int chance(uint64_t *s, double share) { return uniform(s, 0, 1) < share; }
static double either(uint64_t *s, double size) { return below(s, 2) ? size : -size; }
static int chosen(uint64_t *s, double given, int n) { int drawn = below(s, n); return given < 0 ? drawn : (int)given; }
static double larger(double a, double b) { return a > b ? a : b; }
static double smaller(double a, double b) { return a < b ? a : b; }

/* Way for each m/s of a speed that fades for a time. */
static double covered(double time, double tau) { return isfinite(time) ? -tau * expm1(-time / tau) : tau; }

/* Time from the step that is told a limit V until the base is inside, if it was within v_0 before. */
static double inside_by(const numbers *p, const axis_numbers *a, double v_0, double V)
{
    double shortest = (1 - p->jitter) * p->period, longest = (1 + p->jitter) * p->period;
    double spread = p->delay[1] - p->delay[0], least = larger(0, shortest - spread), first = p->delay[1] + p->losses * longest;
    if (v_0 <= V) return first;
    if (V <= a->push) return NEVER;
    double fades = a->tau[1] * log((v_0 - a->push) / (V - a->push)), n = ceil((fades + spread) / shortest - 1e-9);
    return first + smaller(fades + least, (n + p->losses) * longest);
}

static double roll_of(const numbers *p, const axis_numbers *a)
{
    return a->push > 0 ? a->push * (p->rest - covered(p->rest, a->tau[0])) : 0;
}

/* Least speed away to which a command comes in the long run; V: limit of that side. */
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

typedef struct {
    const numbers *p, *real;
    const choices *c;
    uint64_t seed;
    int axis, side, base, driver, limits, noise, delays, losing, jitter, other;
    double t, x[2], v[2], walls[2][2]; /* walls: distance from the start, ahead and behind */
    double tau[2], gain[2], push[2], nearing[2];
    int touched[2][2], braked;
    double zero_since, brakes_after;
    deadline due[2][2];
    result *out;
} drive;

/* One axis over a piece of time in which nothing changes. */
static void carried(drive *s, int i, double h, double u)
{
    double m = s->gain[i] * u + s->push[i], tau = s->tau[i], v = s->v[i], x = s->x[i];
    double fades = -expm1(-h / tau), after = v + (m - v) * fades, far = x + m * h + (v - m) * tau * fades;
    if (s->braked) { after = v = 0; far = x; }
    double turns = v * after < 0 ? tau * log((v - m) / -m) : h; /* until it stands for a moment */
    for (int k = 0; k < 2; ++k) {
        double way = k ? -1 : 1, before = way * v, then = way * after, most = larger(before, then);
        double speed = i == 0 ? s->nearing[k] : 0, wall = s->walls[i][k];
        s->out->over = larger(s->out->over, most / s->p->axes[i].limits[k]);
        if (!s->touched[i][k] && most > 0) {
            double until = before > 0 ? turns : h;
            double at = x + m * until - (v - m) * tau * expm1(-until / tau);
            s->out->gap = smaller(s->out->gap, wall - speed * until - way * (s->braked ? x : at));
        }
        s->walls[i][k] = wall - speed * h;
        if (s->walls[i][k] < way * far) s->touched[i][k] = 1;
        deadline *d = &s->due[i][k];
        if (s->t + h >= d->due) s->out->late = larger(s->out->late, (s->t >= d->due ? most : then) - d->limit);
        if (d->due < NEVER && d->before > d->limit && before > d->limit) {
            double until = then > d->limit ? h : tau * log((v - m) / (way * d->limit - m));
            double promised = d->due - d->told + s->c->less * s->p->period;
            s->out->used = larger(s->out->used, (s->t + until - d->told) / promised);
        }
    }
    s->x[i] = far;
    s->v[i] = after;
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
}

/* What the driver asks for next on the axis that is tried, away from the wall being -1. */
typedef struct { double asked, away, other; int left, turn; } driver;

/* Requests away from one side: commands sent in a row, their least pull, releases that came too early. */
typedef struct { int sent, spent, refused; double weakest; } request;

static void asks(drive *s, driver *d, int k, int stands, double tail)
{
    uint64_t *r = &s->seed;
    double T = s->p->period, t = k * T;
    int near = s->c->start > 0;
    switch (s->driver) {
    case PRESS: d->asked = FULL; break;
    case ANY: if (chance(r, 0.05)) d->asked = uniform(r, -1.5, 1.5); break;
    case TO_AND_FRO: if (chance(r, 0.1)) d->asked = chance(r, 0.6) ? FULL : -FULL; break;
    case ON_AND_OFF: d->asked = (k / 15) % 2 ? 0 : FULL; break;
    case ODD:
        if (chance(r, 0.3)) {
            static const double some[] = {FULL, -FULL, 0, 1e-3, -1e-3, 0.05, -0.05, 1e-12, -1e-12, 0.3, -0.3};
            d->asked = some[below(r, 11)];
        }
        break;
    case TURN_BACK: d->asked = k < d->turn ? FULL : -FULL; break;
    case SMALL: if (chance(r, 0.5)) d->asked = uniform(r, -0.2, 0.2); break;
    default:
        if (d->left > 0) { --d->left; break; }
        if (s->driver == BACK) d->asked = t > 8 || near ? -d->away : FULL;
        else if ((s->driver == TAPS || s->driver == ONE_STEP) && !near && t < 6) d->asked = FULL;
        else if (s->driver == TAPS) {
            int goes = d->asked < 0;
            d->asked = goes ? 0 : -d->away;
            d->left = goes ? below(r, (int)(1.5 * smaller(s->p->rest, 1) / T) + 1) : below(r, 6);
        } else if (s->driver == ONE_STEP) d->asked = stands && d->asked >= 0 ? -d->away : 0;
        else if (s->driver == SLOWLY) { d->asked = d->asked > 0 ? -d->away : FULL; d->left = 100; }
        else {
            int c = below(r, 8);
            d->asked = c < 2 ? FULL : c < 5 ? -d->away : c == 5 ? 0 : c == 6 ? uniform(r, -0.3, 0.3) : either(r, below(r, 2) ? 1e-3 : 0.06);
            d->left = below(r, 40);
        }
    }
    double V = smaller(s->p->axes[1 - s->axis].limits[0], s->p->axes[1 - s->axis].limits[1]);
    switch (s->other) {
    case 0: d->other = 0; break;
    case 1: if (k == 0) d->other = uniform(r, -V, V); break;
    case 2: if (chance(r, 0.1)) d->other = uniform(r, -1.5 * V, 1.5 * V); break;
    case 3: if (chance(r, 0.1)) d->other = chance(r, 0.5) ? 0 : either(r, FULL); break;
    default: d->other = d->asked == 0 ? 0 : either(r, 1e-3);
    }
    if (t >= tail) { d->asked = -d->away; d->other = 0; }
}

static void drive_one(const numbers *p, const numbers *real, const choices *c, uint64_t seed, result *out)
{
    drive s = {.p = p, .real = real, .c = c, .out = out};
    s.seed = seed;
    for (int k = 0; k < 4; ++k) mixed(&s.seed);
    uint64_t *r = &s.seed;
    *out = (result){.gap = NEVER, .late = -NEVER, .stopped = -1, .used = 0, .waits = 0};
    s.axis = c->axis < 0 ? below(r, 4) == 0 : (int)c->axis;
    s.side = chosen(r, c->side, 2) ? -1 : 1;
    s.base = chosen(r, c->base, BASES);
    s.driver = chosen(r, c->driver, DRIVERS);
    int leaving = s.driver >= BACK, near = c->start > 0 ;
    s.limits = chosen(r, c->limits, LIMITS);
    s.noise = below(r, 3);
    s.delays = below(r, 6);
    s.losing = below(r, 2);
    s.jitter = below(r, 4);
    s.other = s.base == GREEDY && c->driver >= 0 && c->driver < BACK ? 0 : below(r, 3) ? below(r, 5) : 0;
    if (s.base == GREEDY && chance(r, 0.7)) { s.noise = 0; s.delays = 1; s.losing = 1; s.jitter = 1; }
    out->shapes = s.driver + 100 * s.base + 1000 * s.limits + 10000 * s.delays + 100000 * s.axis + (s.side < 0) * 1000000;
    const axis_numbers *mine = &p->axes[s.axis];
    int near_side = s.side > 0 ? 0 : 1;
    double T = p->period, roll = roll_of(p, mine), V_away = mine->limits[1 - near_side];

    /* where things are */
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 2; ++k) s.walls[i][k] = NEVER;
    if (c->far[1] > 0) {
        s.walls[s.axis][near_side] = uniform(r, c->far[0], c->far[1]);
        s.walls[s.axis][1 - near_side] = leaving ? (s.axis ? NEVER : 40) : uniform(r, c->far[0], c->far[1]);
        if (near) s.walls[s.axis][near_side] = p->leave * roll + (below(r, 2) ? 0 : uniform(r, 0, 0.1));
        else if (s.axis == 0 && chance(r, 0.3) && !leaving) /* angles as well */
            for (int k = 0; k < 2; ++k) s.walls[1][k] = uniform(r, 0, 3);
    }

    double tail = leaving && !c->rule ? c->seconds - 12 : NEVER;
    driver d = {.turn = 40 + below(r, 60)};
    d.away = below(r, 2) ? FULL : (2.5 * mine->push / mine->gain[0] + uniform(r, 0, 0.3));
    if (d.away <= 0) d.away = 0.1;
    if (s.driver == ALL_SORTS || s.driver == SLOWLY) d.asked = -1;

    for (int i = 0; i < 2; ++i) {
        const axis_numbers *a = &real->axes[i];
        s.tau[i] = uniform(r, a->tau[0], a->tau[1]);
        s.gain[i] = uniform(r, a->gain[0], a->gain[1]);
        s.push[i] = uniform(r, -a->push, a->push);
        for (int k = 0; k < 2; ++k) s.due[i][k] = (deadline){p->axes[i].limits[k], p->axes[i].limits[k], 0, 0};
    }
    s.braked = isfinite(real->rest);
    s.zero_since = 0;

    double cmd[MOST][2], take[MOST][2], when[MOST], speed[MOST][2], where[MOST][2][2];
    wmr_filter_parameters parameters;
    wmr_filter_state state;
    wmr_filter_inputs u;
    wmr_filter_outputs y;
    memset(&u, 0, sizeof u);
    wmr_filter_defaults(&parameters);
    wmr_filter_start(&state);

    int n = (int)(c->seconds / T), acting[2] = {-1, -1}, lost = 0, zeros = 0, owed = 0, owing[2] = {0, 0};
    int phase_left = 0, waiting = 0, changed = 0;
    request leaves[2][2] = {{{0, 0, 0, NEVER}, {0, 0, 0, NEVER}}, {{0, 0, 0, NEVER}, {0, 0, 0, NEVER}}};
    for (int i = 0; i < 2; ++i)
        for (int m = 0; m < 2; ++m) /* a base put nearer than the filter would have stopped it */
            if (s.walls[i][m] < p->leave * roll_of(p, &p->axes[i])) leaves[i][m].spent = (int)p->leave;
    double last_take[2] = {-NEVER, -NEVER}, last_heard[2] = {-NEVER, -NEVER}, held_after = isfinite(p->rest) ? zeros_until_rest(p) : NEVER;
    double ceiling[2][2], told_dt = 0, odometry[2] = {0, 0}, error[2][2] = {{0, 0}, {0, 0}}, owed_pull = 0;
    double quiet = 0, sum = 0;
    int back = (int)(real->free_age / T + 1e-9);
    if (n > MOST) n = MOST;
    for (int i = 0; i < 2; ++i) for (int k = 0; k < 2; ++k) ceiling[i][k] = p->axes[i].limits[k];

    for (int k = 0; k < n; ++k) {
        /* things go away, and others come from afar */
        if (s.driver < BACK && !c->rule && s.base != GREEDY && chance(r, 0.01))
            s.walls[s.axis][below(r, 2)] += uniform(r, 0, 2);

        /* limits */
        int changes = 0;
        if (s.limits != CONSTANT && phase_left-- <= 0 && owed == 0 && k * T < tail - 2) {
            changes = k > 0;
            phase_left = s.limits == KEPT ? 30 + below(r, (int)(6 * mine->tau[1] / T) + 60) : below(r, 40);
            if (k == 0) phase_left = 40 + below(r, 60);
            for (int i = 0; i < 2; ++i)
                for (int m = 0; m < 2; ++m) {
                    double V = p->axes[i].limits[m], push = p->axes[i].push, share = uniform(r, 0, 1);
                    ceiling[i][m] = k == 0 && chance(r, 0.7) ? V : push + (V - push) * (below(r, 3) ? share * share : share);
                    if (s.limits >= NOISY && chance(r, 0.1)) ceiling[i][m] = 0;
                }
        }
        if (k * T >= tail - 2 && s.limits != CONSTANT) { /* the last request is made within the widest limits */
            changes = 1;
            s.limits = CONSTANT;
            for (int i = 0; i < 2; ++i) for (int m = 0; m < 2; ++m) ceiling[i][m] = p->axes[i].limits[m];
        }
        changed = changes ? 20 : changed - 1;
        if (changes)
            for (int i = 0; i < 2; ++i)
                for (int m = 0; m < 2; ++m) {
                    deadline *e = &s.due[i][m];
                    double from = s.t >= e->due ? e->limit : larger(e->limit, e->before);
                    double to = smaller(larger(ceiling[i][m], p->axes[i].push), p->axes[i].limits[m]);
                    double lasts = inside_by(p, &p->axes[i], from, to);
                    *e = (deadline){to, from, s.t, lasts >= NEVER ? NEVER : s.t + lasts - c->less * T};
                }
        for (int i = 0; i < 2; ++i)
            for (int m = 0; m < 2; ++m) {
                double told = ceiling[i][m];
                if (s.limits == NOISY && owed == 0) told *= uniform(r, 0.9, 1);
                if (s.limits == FALLING && owed == 0) told *= larger(0, 1 - 0.01 * (k % 100));
                if (s.limits == BROKEN && owed == 0 && chance(r, 0.05)) told = below(r, 2) ? NAN : uniform(r, -1, 0);
                if (s.limits == CONSTANT && ceiling[i][m] >= p->axes[i].limits[m] && below(r, 2)) told = INFINITY;
                u.limits[2 * i + 1 - m] = m ? -told : told;
            }

        /* odometry and distances */
        for (int i = 0; i < 2; ++i) {
            double n_bar = real->axes[i].odometry, way = i == s.axis ? s.side : 1;
            if (s.noise == 0) { odometry[i] = -way * n_bar; error[i][0] = error[i][1] = real->error; }
            else if (s.noise == 1) {
                odometry[i] = uniform(r, -n_bar, n_bar);
                for (int m = 0; m < 2; ++m) error[i][m] = uniform(r, -real->error, real->error);
            } else if (k % 7 == 0) {
                odometry[i] = either(r, n_bar);
                for (int m = 0; m < 2; ++m) error[i][m] = either(r, real->error);
            }
            for (int m = 0; m < 2; ++m) where[k][i][m] = s.walls[i][m] - (m ? -s.x[i] : s.x[i]);
        }
        when[k] = s.t;
        int heard = p->heard > 0 && (s.noise != 2 || chance(r, 0.7));
        int ago = s.noise == 0 ? k - (int)(real->age / T + 1e-9) : k - below(r, (int)(real->age / T + 1e-9) + 1);
        while (ago < k && (ago < 0 || s.t - when[ago] > real->age + SAME)) ++ago;
        u.odometry_age = heard ? smaller(s.t - when[ago], p->age) : -1;
        for (int i = 0; i < 2; ++i) u.v_odometry[i] = (speed[k][i] = s.v[i], speed[ago][i]) + odometry[i];
        if (heard && chance(r, 0.01) && s.noise == 2) u.v_odometry[below(r, 2)] = NAN;
        int source = s.noise == 0 ? k - back : k - below(r, back + 1);
        while (source < k && source >= 0 && s.t - when[source] > real->free_age + SAME) ++source;
        int seen = source >= 0 && (k == back || !chance(r, c->missing));
        u.free_age = seen ? smaller(s.t - when[source], p->free_age) : -1;
        for (int i = 0; i < 2; ++i)
            for (int m = 0; m < 2; ++m) {
                double far = seen ? where[source][i][m] + (i ? 0 : error[i][m]) : NAN;
                u.free[2 * i + m] = far > 1e9 ? INFINITY : seen && c->missing > 0 && chance(r, 0.05) ? NAN : far;
            }

        /* what is asked for */
        int stands = zeros > held_after;
        asks(&s, &d, k, stands, tail);
        u.v_asked[s.axis] = s.side * d.asked;
        u.v_asked[1 - s.axis] = d.other;
        if (owed > 0) { /* the driver goes on */
            int i = owing[0], way = owing[1] ? 1 : -1;
            --owed;
            u.v_asked[i] = way * larger(way * u.v_asked[i], owed_pull);
            u.v_asked[1 - i] = 0;
        }
        if (s.noise == 2 && owed == 0 && k * T < tail && chance(r, 0.002)) u.v_asked[below(r, 2)] = NAN;
        u.elapsed = told_dt;

        double sent[2];
        int near_by = 0;
        if (c->rule) {
            double distance = larger(u.free[near_side], 0), asked = smaller(d.asked, c->rule_numbers[0]);
            sent[s.axis] = s.side * (asked <= 0 ? asked : c->rule == APPROACH ? approach(distance, asked, c->rule_numbers[1])
                           : smaller(asked, sqrt(2 * c->rule_numbers[1] * larger(0, distance - c->rule_numbers[2]))));
            sent[1 - s.axis] = 0;
        } else {
            int spent = 0;
            for (int i = 0; i < 2; ++i) for (int m = 0; m < 2; ++m) spent += leaves[i][m].spent;
            if (spent > 0) { /* is every side open? */
                wmr_filter_state tried = state;
                wmr_filter_inputs none = u;
                none.v_asked[0] = none.v_asked[1] = 0;
                wmr_filter_step(&parameters, &tried, &none, &y);
                if (!((long)y.filter_flags & NEAR_BY))
                    for (int i = 0; i < 2; ++i) for (int m = 0; m < 2; ++m) leaves[i][m].spent = 0;
            }
            wmr_filter_step(&parameters, &state, &u, &y);
            near_by = ((long)y.filter_flags & NEAR_BY) != 0;
            for (int i = 0; i < 2; ++i) sent[i] = y.v_sent[i];
        }
        if (!(isfinite(sent[0]) && isfinite(sent[1]))) out->over = NEVER;

        /* what the driver owes, and how long a request waits */
        double towards = s.side * sent[s.axis];
        int goes = towards < 0;
        for (int i = 0; i < 2; ++i)
            for (int m = 0; m < 2; ++m) {
                const axis_numbers *a = &p->axes[i];
                request *e = &leaves[i][m];
                double way = m ? 1 : -1, told = way * u.limits[2 * i + m];
                double V = larger(a->push, smaller(isnan(told) ? 0 : told, a->limits[1 - m]));
                if (way * sent[i] > 0) {
                    double pull = pull_of(a, sent[i], V), hold = hold_of(p, a, pull);
                    if (e->sent == 0) e->weakest = NEVER;
                    ++e->sent;
                    e->weakest = smaller(e->weakest, pull);
                    if (e->refused) {
                        ++out->holds;
                        if (s.walls[i][m] < 1e9 && sent[1 - i] == 0 && e->spent >= p->leave && a->push > 0 && hold < NEVER) {
                            owed = (int)hold - 1;
                            owing[0] = i;
                            owing[1] = m;
                            owed_pull = fabs(u.v_asked[i]);
                        }
                    }
                } else if (e->sent > 0) {
                    if (e->sent < hold_of(p, a, e->weakest)) { ++e->spent; ++out->early; }
                    e->sent = 0;
                }
                if (owed > 0 && i == owing[0] && m == owing[1] && way * sent[i] <= 0) owed = 0;
                e->refused = near_by && way * u.v_asked[i] > 0 && sent[i] == 0;
            }
        if (k * T >= tail && waiting >= 0) {
            if (goes) waiting = -1;
            else if (owed == 0) {
                ++waiting;
                double V = V_away, pull = pull_of(mine, d.away, V), most = (held_after < NEVER ? held_after : 0) + hold_of(p, mine, pull) + 2;
                if (pull > 1e-9 && s.walls[s.axis][1 - near_side] + s.side * s.x[s.axis] > 5 && p->nearing == 0) out->waits = larger(out->waits, waiting / most);
            }
        }
        zeros = sent[0] == 0 && sent[1] == 0 ? zeros + 1 : 0;
        for (int i = 0; i < 2; ++i) cmd[k][i] = sent[i];

        /* when it takes over */
        double old = k ? s.side * cmd[k - 1][s.axis] : 0, low = real->delay[0], high = real->delay[1], delay[2];
        for (int i = 0; i < 2; ++i) {
            if (i && c->apart <= 0) { delay[1] = delay[0]; break; }
            switch (s.delays) {
            case 0: delay[i] = uniform(r, low, high); break;
            case 1: delay[i] = towards > old ? low : high; break;
            case 2: delay[i] = towards < 0 ? high : low; break; /* taps are as short as they can be */
            case 3: delay[i] = (k + (int)(seed & 1)) % 2 ? low : high; break;
            case 4: delay[i] = changed > 0 ? high : low; break;
            default: delay[i] = below(r, 2) ? low : high;
            }
            if (i && s.delays != 0 && s.delays != 5) delay[1] = below(r, 2) ? low + high - delay[0] : delay[0];
        }
        int wish = s.losing ? towards < old || (changes && lost < real->losses) : chance(r, 0.4);
        if (lost < real->losses && wish) {
            ++lost;
            take[k][0] = take[k][1] = NEVER;
        } else {
            lost = 0;
            for (int i = 0; i < 2; ++i) take[k][i] = last_take[i] = larger(s.t + delay[i], last_take[i]);
        }
        double j = s.jitter == 0 ? uniform(r, -1, 1) : s.jitter == 1 ? 1 : s.jitter == 2 ? either(r, 1) : towards < 0 ? -1 : 1;
        double dt = T * (1 + real->jitter * j), end = s.t + dt;
        told_dt = T * larger(1 - p->jitter, smaller(1 + p->jitter, dt / T));
        if (c->pauses > 0 && owed == 0 && s.driver < BACK && chance(r, c->pauses)) { /* the program stops for a while */
            double pause = uniform(r, 0, 30) * T;
            end += pause;
            dt = told_dt = dt + pause;
            zeros = 0;
        }

        /* the base */
        int pieces = s.base == GREEDY ? 2 : 4;
        for (int i = 0; i < 2; ++i) s.nearing[i] = real->nearing * (s.base == GREEDY ? 1 : uniform(r, 0, 1));
        for (int piece = 1; s.t < end - SAME;) {
            double now[2];
            for (int i = 0; i < 2; ++i) {
                for (int m = acting[i] + 1; m <= k; ++m) /* those before were lost, or replaced */
                    if (take[m][i] <= s.t + SAME) { acting[i] = m; last_heard[i] = take[m][i]; }
                int quiet_now = real->hold > 0 && s.t >= last_heard[i] + real->hold - SAME;
                now[i] = acting[i] < 0 || quiet_now ? 0 : cmd[acting[i]][i];
            }
            double stop = end;
            while (piece < pieces && end - dt + dt * piece / pieces <= s.t + SAME) ++piece;
            if (piece < pieces) stop = end - dt + dt * piece / pieces;
            for (int i = 0; i < 2; ++i) {
                for (int m = acting[i] + 1; m <= k; ++m) if (take[m][i] > s.t + SAME && take[m][i] < stop) stop = take[m][i];
                double ends = real->hold > 0 ? last_heard[i] + real->hold : NEVER;
                if (ends > s.t + SAME && ends < stop) stop = ends;
                for (int m = 0; m < 2; ++m) if (s.due[i][m].due > s.t + SAME && s.due[i][m].due < stop) stop = s.due[i][m].due;
            }
            if (now[0] != 0 || now[1] != 0) { s.braked = 0; s.zero_since = NEVER; }
            else if (s.zero_since >= NEVER) {
                s.zero_since = s.t;
                s.brakes_after = real->rest * (s.base == GREEDY || below(r, 2) ? 1 : uniform(r, 0, 1));
            }
            if (!s.braked && s.zero_since < NEVER) {
                double closes = s.zero_since + s.brakes_after;
                if (s.t >= closes - SAME) { s.braked = 1; s.v[0] = s.v[1] = 0; }
                else if (closes < stop) stop = closes;
            }
            for (int i = 0; i < 2; ++i) {
                base_chooses(&s, i, now[i]);
                carried(&s, i, stop - s.t, now[i]);
            }
            sum += fabs(s.v[s.axis]) * (stop - s.t);
            s.t = stop;
        }
        quiet = fabs(s.v[s.axis]) < 1e-3 ? quiet + 1 : 0;
        if (out->stopped < 0 && quiet * T > 0.5 && s.side * s.x[s.axis] > 0.02) out->stopped = s.walls[s.axis][near_side] - s.side * s.x[s.axis];
    }
    out->mean = sum / s.t;
    if (c->rule || s.driver == PRESS) out->stopped = s.walls[s.axis][near_side] - s.side * s.x[s.axis];
}

/* ``count`` drives, with seeds from ``seed`` on. */
void wmr_filter_drives(const double *told, const double *real, const double *drawn, long count, unsigned long long seed, double *out)
{
    for (long k = 0; k < count; ++k) {
        uint64_t own = seed + (uint64_t)k;
        drive_one((const numbers *)told, (const numbers *)real, (const choices *)drawn, mixed(&own), (result *)out + k);
    }
}
