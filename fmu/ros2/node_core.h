/* Decisions that both ROS 2 nodes share: events of the clocks, and accepted messages.  The nodes in Python and the node
   in C use the same text.  No ROS, no heap, no globals, no input or output; times in nanoseconds. */
#ifndef WMR_NODE_CORE_H
#define WMR_NODE_CORE_H

#include <stdint.h>

/* ROS time, the steady clock, and whether ROS time is simulated. */
typedef struct {
    int64_t ros, steady, simulated;
} wmr_moment;

/* What can happen to time between two callbacks: bits. */
enum { WMR_TIME_BACK = 1, WMR_TIME_FORTH = 2, WMR_FROZEN = 4, WMR_HAPPENINGS = 3 };

/* Checks the time of each callback; ``longest`` is the longest pause that is not a freeze. */
typedef struct {
    int64_t longest, begun;
    wmr_moment before;
    int64_t counts[WMR_HAPPENINGS];
} wmr_clocks;

/* Reasons for refusing a message. */
enum {
    WMR_TAKEN,
    WMR_NOT_A_NUMBER,
    WMR_WRONG_FRAME,
    WMR_QUEUED,
    WMR_FUTURE,
    WMR_TOO_OLD,
    WMR_REPEATED,
    WMR_NO_ROTATION,
    WMR_NO_STAMP,
    WMR_OTHER_PARTS,
    WMR_UNUSABLE,
    WMR_REASONS
};

/* Stamps of a topic's messages; ``timeout``: older ones are refused. */
typedef struct {
    int64_t timeout, stamp, stamped, arrived, there, late, thawed, taken, refused[WMR_REASONS];
} wmr_intake;

/* Events of the clocks since the last look.  Simulated time may run at any rate, so only its leaps are jumps ahead. */
int64_t wmr_clocks_see(wmr_clocks *clocks, const wmr_moment *now);

/* Takes a message of ``count`` values; ``framed``: its frame is the right one; ``stamp`` 0: it has none.  Simulated
   time has one clock, which a message may overtake: there a stamp may be ahead by the time-out, and a message is new
   when it arrives. */
int64_t wmr_intake_take(
    wmr_intake *intake, int64_t count, const double *values, int64_t framed, int64_t stamp, const wmr_moment *now);

/* Counts a refused message; returns the reason. */
int64_t wmr_intake_refuse(wmr_intake *intake, int64_t reason);

/* Age of the message's data [s]; -1 without a message. */
double wmr_intake_age(const wmr_intake *intake, const wmr_moment *now);

/* Reset, as after a jump of ROS time. */
void wmr_intake_forget(wmr_intake *intake);

/* The reason in words. */
const char *wmr_reason(int64_t reason);

/* Whether a message's frame is the wanted one: "" wants none, and one without passes unless it must be ``named``. */
int64_t wmr_frame_fits(const char *wanted, const char *given, int64_t named);

/* True if the quaternion's length is 1 to within ``slack``. */
int64_t wmr_is_rotation(const double *quaternion, double slack);

#endif
