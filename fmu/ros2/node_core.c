#include "node_core.h"

#include <math.h>
#include <string.h>

/* ROS time may go back, or fall behind, by this much before it counts as a jump. */
#define SLACK INT64_C(10000000)
/* ROS time that gains so much on the steady clock has jumped ahead. */
#define JUMP INT64_C(500000000)
/* A stamp this far in the future comes from another machine's clock. */
#define AHEAD INT64_C(50000000)

int64_t wmr_clocks_see(wmr_clocks *clocks, const wmr_moment *now)
{
    const wmr_moment before = clocks->before;
    const int64_t begun = clocks->begun, passed = now->ros - before.ros, steady = now->steady - before.steady;
    int64_t happened;

    clocks->before = *now;
    clocks->begun = 1;
    if (!begun || before.simulated != now->simulated) {
        return 0;
    }
    happened = passed < -SLACK ? WMR_TIME_BACK : 0;
    happened |= passed - steady > JUMP ? WMR_TIME_FORTH : 0;
    happened |= steady > clocks->longest ? WMR_FROZEN : 0;
    for (int k = 0; k < WMR_HAPPENINGS; ++k) {
        clocks->counts[k] += happened >> k & 1;
    }
    return happened;
}

static int64_t objection(
    const wmr_intake *intake, int64_t count, const double *values, int64_t framed, int64_t stamp, const wmr_moment *now)
{
    for (int64_t k = 0; k < count; ++k) {
        if (!isfinite(values[k])) {
            return WMR_NOT_A_NUMBER;
        }
    }
    if (!framed) {
        return WMR_WRONG_FRAME;
    }
    if (!stamp) {
        return intake->thawed ? WMR_QUEUED : WMR_TAKEN;
    }
    if (stamp > now->ros + (now->simulated ? intake->timeout : AHEAD)) {
        return WMR_FUTURE;
    }
    if (now->ros - stamp > intake->timeout) {
        return WMR_TOO_OLD;
    }
    return intake->stamped && stamp <= intake->stamp ? WMR_REPEATED : WMR_TAKEN;
}

int64_t wmr_intake_take(
    wmr_intake *intake, int64_t count, const double *values, int64_t framed, int64_t stamp, const wmr_moment *now)
{
    const int64_t reason = objection(intake, count, values, framed, stamp, now), late = now->ros - stamp;

    intake->thawed = 0;
    if (reason) {
        return wmr_intake_refuse(intake, reason);
    }
    intake->arrived = now->steady;
    intake->there = 1;
    intake->late = stamp && !now->simulated && late > 0 ? late : 0;
    if (stamp) {
        intake->stamp = stamp;
        intake->stamped = 1;
    }
    ++intake->taken;
    return WMR_TAKEN;
}

int64_t wmr_intake_refuse(wmr_intake *intake, int64_t reason)
{
    ++intake->refused[reason];
    return reason;
}

double wmr_intake_age(const wmr_intake *intake, const wmr_moment *now)
{
    return intake->there ? (double)(intake->late + now->steady - intake->arrived) * 1e-9 : -1.0;
}

void wmr_intake_forget(wmr_intake *intake)
{
    intake->stamped = intake->there = 0;
}

const char *wmr_reason(int64_t reason)
{
    static const char *const words[WMR_REASONS] = {
        "",
        "not a number",
        "wrong frame",
        "queued while this process stood still",
        "from the future",
        "too old",
        "repeated or out of order",
        "not a rotation",
        "without a stamp",
        "other parts of the twist",
        "of a size or with angles that cannot be used",
    };
    return words[reason];
}

int64_t wmr_frame_fits(const char *wanted, const char *given, int64_t named)
{
    return !*wanted || !strcmp(wanted, given) || (!*given && !named);
}

int64_t wmr_is_rotation(const double *q, double slack)
{
    return fabs(sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) - 1.0) < slack;
}
