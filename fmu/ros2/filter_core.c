#include "filter_core.h"

#include <string.h>

#include "gate.h"

/* Off the period by this much [ns] is on it: stamps are whole nanoseconds.  It moves |v| by less than the filter's reserve. */
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
    core->clocks.longest = WMR_LONGEST;
    core->scale = 1.0;
    wmr_filter_core_start(core);
}

static void forget(wmr_filter_core *core)
{
    wmr_intake_forget(&core->commands);
    wmr_intake_forget(&core->odometry);
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

/* On simulated time a simulator says how much has passed between two commands; else nobody is trusted with that but the
   steady clock. */
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

/* Time since the last tick [s], for a command that is answered or a timer; 0: the period; negative: time stood still.  By the
   steady clock, but between stamps on simulated time: a clock that jumps forward would break a band's limit. */
static double elapsed(const wmr_filter_core *core, int64_t stamp, const wmr_moment *now)
{
    const int64_t stamped = now->simulated && core->answered && core->stamp && stamp;
    const int64_t time = stamped ? stamp - core->stamp : now->steady - core->before;
    const int64_t off = time - WMR_PERIOD;

    return !core->before || (-ROUNDED <= off && off <= ROUNDED) ? 0.0 : time ? (double)time * 1e-9 : -1.0;
}

/* Age of odometry [s], negative: there is none.  A base that is simulated moves in simulated time, in which a command's
   stamp says when it is answered; the time-out stays on the steady clock. */
static double odometry_age(const wmr_filter_core *core, int64_t answered, int64_t stamp, const wmr_moment *now)
{
    const wmr_intake *odometry = &core->odometry;
    const int64_t since = (answered && stamp ? stamp : now->ros) - odometry->stamp;
    const double age = wmr_intake_age(odometry, now);

    if (!now->simulated || !odometry->stamped || age < 0.0 || age > WMR_ODOMETRY_TIMEOUT * 1e-9) {
        return age;
    }
    return since > 0 ? (double)since * 1e-9 : 0.0;
}

void wmr_filter_core_tick(wmr_filter_core *core, int64_t answered, int64_t stamp, const wmr_moment *now)
{
    static const double parameters[] = WMR_GATE_PARAMETERS;
    const double u[9] = {
        core->scale * core->command[0],
        core->scale * core->command[1],
        wmr_intake_age(&core->commands, now),
        core->measured[0],
        core->measured[1],
        odometry_age(core, answered, stamp, now),
        elapsed(core, stamp, now),
        (double)core->stop,
        (double)core->reset,
    };
    double next[WMR_GATE_STATE], y[3];

    wmr_gate(u, core->gate, parameters, next, y);
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
