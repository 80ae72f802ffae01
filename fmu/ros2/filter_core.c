#include "filter_core.h"

#include <math.h>
#include <string.h>

#include "gate.h"

/* Difference from the period [ns] that counts as none: stamps are whole nanoseconds.  It changes |v| by less than the
   filter's reserve. */
#define ROUNDED 2

int64_t wmr_filter_core_size(void)
{
    return (int64_t)sizeof(wmr_filter_core);
}

void wmr_filter_core_make(wmr_filter_core *core)
{
    memset(core, 0, sizeof *core);
    core->commands.timeout = WMR_COMMAND_TIMEOUT;
    core->odometry.timeout = WMR_ODOMETRY_TIMEOUT;
#ifdef WMR_AT_FREE
    for (int k = 0; k < WMR_LASERS; ++k) {
        core->frees[k].timeout = WMR_FREE_TIMEOUT;
    }
#endif
    core->clocks.longest = WMR_LONGEST;
    core->scale = 1.0;
    wmr_filter_core_start(core);
}

static void forget(wmr_filter_core *core)
{
    wmr_intake_forget(&core->commands);
    wmr_intake_forget(&core->odometry);
    for (int k = 0; k < WMR_LASERS; ++k) {
        wmr_intake_forget(&core->frees[k]);
    }
}

void wmr_filter_core_start(wmr_filter_core *core)
{
    static const double start[] = WMR_GATE_START;

    memcpy(core->gate, start, sizeof core->gate);
    core->clocks.begun = core->reset = core->before = core->answered = core->stamp = 0;
    forget(core);
}

int64_t wmr_filter_core_see(wmr_filter_core *core, const wmr_moment *now)
{
    const int64_t happened = wmr_clocks_see(&core->clocks, now);

    if (happened & WMR_TIME_BACK) {
        forget(core);
        core->answered = 0;
    }
    if (happened & WMR_FROZEN) {
        core->commands.thawed = core->odometry.thawed = 1;
        for (int k = 0; k < WMR_LASERS; ++k) {
            core->frees[k].thawed = 1;
        }
    }
    return happened;
}

static int64_t keep(int64_t reason, double *kept, const double *velocity)
{
    if (!reason) {
        memcpy(kept, velocity, 2 * sizeof *kept);
    }
    return reason;
}

int64_t wmr_filter_core_command(
    wmr_filter_core *core, const double *velocity, int64_t framed, int64_t stamp, const wmr_moment *now)
{
    return keep(wmr_intake_take(&core->commands, 2, velocity, framed, stamp, now), core->command, velocity);
}

int64_t wmr_filter_core_odometry(wmr_filter_core *core, const double *velocity, const double *quaternion,
    int64_t framed, int64_t stamp, const wmr_moment *now)
{
    if (!wmr_is_rotation(quaternion, WMR_UNIT)) {
        return wmr_intake_refuse(&core->odometry, WMR_NO_ROTATION);
    }
    return keep(wmr_intake_take(&core->odometry, 2, velocity, framed, stamp, now), core->measured, velocity);
}

void wmr_filter_core_limit(wmr_filter_core *core, int64_t topic, const double *pair, const wmr_moment *now)
{
    memcpy(core->limits[topic], pair, sizeof core->limits[topic]);
    core->limited[topic] = now->steady;
}

int64_t wmr_filter_core_free(wmr_filter_core *core, const double *ways, int64_t count, const wmr_moment *now)
{
    int64_t reason;

    if (count != 4) {
        return wmr_intake_refuse(&core->frees[0], WMR_UNUSABLE);
    }
    reason = wmr_intake_take(&core->frees[0], 0, ways, 1, 0, now);
    if (!reason) {
        memcpy(core->told, ways, sizeof core->told);
    }
    return reason;
}

#if WMR_SCANS
int64_t wmr_filter_core_scan(
    wmr_filter_core *core, int64_t laser, const wmr_beams *beams, int64_t stamp, const wmr_moment *now)
{
    wmr_intake *intake = &core->frees[laser];
    int64_t reason = !wmr_scan_usable(beams) ? WMR_UNUSABLE : !stamp ? WMR_NO_STAMP : WMR_TAKEN;

    if (reason) {
        return wmr_intake_refuse(intake, reason);
    }
    reason = wmr_intake_take(intake, 0, NULL, 1, stamp, now);
    if (!reason) {
        wmr_scan_take(laser, beams, &core->sights[laser], core->points[laser]);
    }
    return reason;
}

int64_t wmr_filter_core_never(const wmr_filter_core *core)
{
    for (int k = 0; k < WMR_SCANS; ++k) {
        if (!core->frees[k].there) {
            return 0;
        }
    }
    return wmr_scan_never(core->sights);
}
#else
int64_t wmr_filter_core_scan(
    wmr_filter_core *core, int64_t laser, const wmr_beams *beams, int64_t stamp, const wmr_moment *now)
{
    (void)laser;
    (void)beams;
    (void)stamp;
    (void)now;
    return wmr_intake_refuse(&core->frees[0], WMR_UNUSABLE);
}

int64_t wmr_filter_core_never(const wmr_filter_core *core)
{
    (void)core;
    return 0;
}
#endif

/* On simulated time the simulator says how much time has passed between two commands; otherwise only the steady clock
   does. */
int64_t wmr_filter_core_due(const wmr_filter_core *core, int64_t stamp, const wmr_moment *now)
{
    const int64_t stamped = now->simulated && core->stamp && stamp;
    const int64_t passed = stamped ? stamp - core->stamp : now->steady - core->before;

    return !core->answered || passed >= WMR_PERIOD / 4 * 3;
}

int64_t wmr_filter_core_overdue(const wmr_filter_core *core, const wmr_moment *now)
{
    const int64_t late = !core->answered ? 0 : now->simulated ? WMR_COMMAND_TIMEOUT : WMR_PERIOD / 4;

    return !core->before || now->steady - core->before >= WMR_PERIOD + late;
}

/* Time since the last tick [s], for an answered command or a timer; 0: the period; negative: time stood still.  It is
   by the steady clock, or between stamps on simulated time: a clock that jumps forward would break a band's limit. */
static double elapsed(const wmr_filter_core *core, int64_t stamp, const wmr_moment *now)
{
    const int64_t stamped = now->simulated && core->answered && core->stamp && stamp;
    const int64_t time = stamped ? stamp - core->stamp : now->steady - core->before;
    const int64_t off = time - WMR_PERIOD;

    return !core->before || (-ROUNDED <= off && off <= ROUNDED) ? 0.0 : time ? (double)time * 1e-9 : -1.0;
}

/* Age of a message's data [s]; negative: there is none.  A simulated base moves in simulated time, in which a command's
   stamp says when it is answered; the time-out is always by the steady clock. */
static double age_of(const wmr_intake *intake, int64_t answered, int64_t stamp, const wmr_moment *now)
{
    const int64_t since = (answered && stamp ? stamp : now->ros) - intake->stamp;
    const double age = wmr_intake_age(intake, now);

    if (!now->simulated || !intake->stamped || age < 0.0 || age > (double)intake->timeout * 1e-9) {
        return age;
    }
    return since > 0 ? (double)since * 1e-9 : 0.0;
}

#ifdef WMR_AT_LIMITS
/* The smaller number, or NaN if one is NaN. */
static double smaller(double one, double other)
{
    return isnan(one) || one < other ? one : other;
}

/* True if limits that must come regularly are missing: ~/v_max, and each topic that ever came, except a speed limit,
   which comes when it changes. */
static int is_silent(const wmr_filter_core *core, const wmr_moment *now)
{
    int silent = 0;

    for (int k = 0; k < WMR_SPEED && WMR_LIMIT_TIMEOUT > 0; ++k) {
        const int64_t came = core->limited[k];

        silent |= came ? now->steady - came > WMR_LIMIT_TIMEOUT : k == WMR_V_MAX;
    }
    return silent;
}

/* Limits in force: v_min, v_max, omega_min, omega_max; all no numbers where none came in time, which is a stop. */
static void limits_now(const wmr_filter_core *core, const wmr_moment *now, double *limits)
{
    static const double widest[] = WMR_LIMITS;
    const double *speed = core->limits[WMR_SPEED];
    const int off = core->limited[WMR_ENABLE] && core->limits[WMR_ENABLE][0] == 0.0;

    memcpy(limits, widest, sizeof widest);
    for (int i = 0; i < 2; ++i) {
        double *low = limits + 2 * i, *high = low + 1;

        *high = core->limited[WMR_V_MAX] ? smaller(core->limits[WMR_V_MAX][i], *high) : *high;
        *low = core->limited[WMR_V_MIN] ? -smaller(-core->limits[WMR_V_MIN][i], -*low) : *low;
    }
    if (core->limited[WMR_SPEED] && speed[0] != 0.0) {
        const int percent = speed[1] != 0.0;

        limits[1] = smaller(percent ? speed[0] / 100 * widest[1] : speed[0], limits[1]);
        limits[0] = -smaller(percent ? speed[0] / 100 * -widest[0] : speed[0], -limits[0]);
    }
    for (int k = 0; k < 4; ++k) {
        limits[k] = is_silent(core, now) ? NAN : off ? 0.0 : limits[k];
    }
}
#endif

#ifdef WMR_AT_FREE
/* Age of the oldest message on free distances; negative unless there is one of each. */
static double free_age(const wmr_filter_core *core, int64_t answered, int64_t stamp, const wmr_moment *now)
{
    double oldest = 0.0;

    for (int k = 0; k < WMR_SOURCES; ++k) {
        const double age = age_of(&core->frees[k], answered, stamp, now);

        if (age < 0.0) {
            return age;
        }
        oldest = fmax(oldest, age);
    }
    return oldest;
}

/* Free distances with a window of headings that is wider on the side to which a command turns, or with the smallest
   one; all headings are free if nothing is within the stopping distance. */
static void look(const wmr_filter_core *core, int smallest, double omega, double *free)
{
#if WMR_SCANS
    const double window = smallest ? WMR_SMALLEST : WMR_LOOK;

    free[2] = free[3] = WMR_ANY;
    wmr_scan_ways(core->sights, core->points[0][0], free + 2, free);
    if (fmin(free[0], free[1]) < WMR_ENOUGH) {
        free[2] = fmin(WMR_WIDEST, window + fmax(0.0, WMR_TURNING * omega));
        free[3] = fmin(WMR_WIDEST, window + fmax(0.0, -WMR_TURNING * omega));
        wmr_scan_ways(core->sights, core->points[0][0], free + 2, free);
    }
#else
    (void)smallest;
    (void)omega;
    memcpy(free, core->told, sizeof core->told);
#endif
}
#endif

void wmr_filter_core_tick(wmr_filter_core *core, int64_t answered, int64_t stamp, const wmr_moment *now)
{
    static const double parameters[] = WMR_GATE_PARAMETERS;
    double u[WMR_GATE_INPUTS] = {
        core->scale * core->command[0],
        core->scale * core->command[1],
        wmr_intake_age(&core->commands, now),
        core->measured[0],
        core->measured[1],
        age_of(&core->odometry, answered, stamp, now),
        elapsed(core, stamp, now),
        (double)core->stop,
        (double)core->reset,
    };
    double next[WMR_GATE_STATE], y[3];

#ifdef WMR_AT_LIMITS
    limits_now(core, now, u + WMR_AT_LIMITS);
#endif
#ifdef WMR_AT_FREE
    u[WMR_AT_FREE_AGE] = free_age(core, answered, stamp, now);
    look(core, 0, u[1], u + WMR_AT_FREE);
#endif
    wmr_gate(u, core->gate, parameters, next, y);
#ifdef WMR_AT_FREE
    if ((int64_t)y[2] & WMR_NEAR) { /* drop points that are not in the way straight ahead */
        u[1] = 0.0;
        look(core, 1, 0.0, u + WMR_AT_FREE);
        wmr_gate(u, core->gate, parameters, next, y);
    }
    memcpy(core->free, u + WMR_AT_FREE, sizeof core->free);
#endif
    memcpy(core->gate, next, sizeof next);
    memcpy(core->sent, y, sizeof core->sent);
    core->flags = (int64_t)y[2];
    core->reset = 0;
    core->before = now->steady;
    core->answered = answered;
    core->stamp = stamp;
}

int64_t wmr_filter_core_reset(wmr_filter_core *core)
{
    core->reset = !core->stop;
    return core->reset;
}
