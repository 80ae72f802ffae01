/* Decisions of wmr_filter: messages and ticks to the command that goes to the base.  gate.h is generated: the gate's
   function, its numbers, time-outs. */
#ifndef WMR_FILTER_CORE_H
#define WMR_FILTER_CORE_H

#include "gate_numbers.h"
#include "node_core.h"
#include "scan_core.h"

/* Topics of limits: largest v and omega, least ones, whether any motion is allowed, and a limit of |v| that is 0 for none,
   with 1 if it is a percentage. */
enum { WMR_V_MAX, WMR_V_MIN, WMR_ENABLE, WMR_SPEED, WMR_LIMIT_TOPICS };

/* ``stop``: value of the topic ~/stop.  ``scale``: share of each command that is passed on.  ``sent``, ``flags``: last
   command sent and its flags; ``before``: its time [steady]; ``answered``: 1 if it answered a command.  ``stamp``: stamp
   of the last command that was answered.  ``limits``: newest messages on limits, by topic; ``limited``: times of their
   arrival [steady].  ``frees``: messages with free distances: scans, or ``told`` alone.  ``free``: last distances given
   to the gate: ahead, behind, left, right. */
typedef struct {
    wmr_intake commands, odometry, frees[WMR_LASERS];
    wmr_clocks clocks;
    int64_t stop, reset, before, answered, stamp, flags, limited[WMR_LIMIT_TOPICS];
    double command[2], measured[2], scale, sent[2], limits[WMR_LIMIT_TOPICS][2], told[4], free[4];
    wmr_sight sights[WMR_LASERS];
    double gate[WMR_GATE_STATE];
#if WMR_SCANS
    double points[WMR_SCANS][WMR_BEAMS][2];
#endif
} wmr_filter_core;

int64_t wmr_filter_core_size(void);

/* Everything at its start. */
void wmr_filter_core_make(wmr_filter_core *core);

/* Reset: no command, no odometry, nothing latched; counters, ~/stop and scale stay. */
void wmr_filter_core_start(wmr_filter_core *core);

/* Checks the clocks and returns their events.  After a jump back earlier messages are forgotten.  After a freeze the
   gate sees the age of everything, and messages without a stamp that have waited are refused. */
int64_t wmr_filter_core_see(wmr_filter_core *core, const wmr_moment *now);

/* Takes a command; returns the reason if it is refused. */
int64_t wmr_filter_core_command(
    wmr_filter_core *core, const double *velocity, int64_t framed, int64_t stamp, const wmr_moment *now);

/* Takes odometry: v, omega, and the quaternion of its pose. */
int64_t wmr_filter_core_odometry(wmr_filter_core *core, const double *velocity, const double *quaternion,
    int64_t framed, int64_t stamp, const wmr_moment *now);

/* Takes a message of a topic of limits: two numbers, which may be none.  It stays in force over a start. */
void wmr_filter_core_limit(wmr_filter_core *core, int64_t topic, const double *pair, const wmr_moment *now);

/* Takes free distances ahead, behind [m], left and right [rad]; those that are no numbers count as not told. */
int64_t wmr_filter_core_free(wmr_filter_core *core, const double *ways, int64_t count, const wmr_moment *now);

/* Takes the scan of a laser. */
int64_t wmr_filter_core_scan(
    wmr_filter_core *core, int64_t laser, const wmr_beams *beams, int64_t stamp, const wmr_moment *now);

/* Sides that are never free, since no beam covers them: WMR_AHEAD, WMR_BEHIND; 0 until each laser was heard. */
int64_t wmr_filter_core_never(const wmr_filter_core *core);

/* Whether a command that came now is answered at once, or leaves that to the timer: not sooner than three quarters of a
   period after a command that was answered, at once after the timer, so that answers find back to their commands. */
int64_t wmr_filter_core_due(const wmr_filter_core *core, int64_t stamp, const wmr_moment *now);

/* True if the timer must answer although commands are answered as they come: the next command may be late by a quarter
   of a period, or on simulated time, which may be slow, by the time-out. */
int64_t wmr_filter_core_overdue(const wmr_filter_core *core, const wmr_moment *now);

/* The command for the base, into ``sent`` and ``flags``; ``stamp`` is that of a command that is ``answered``, 0 where it
   has none. */
void wmr_filter_core_tick(wmr_filter_core *core, int64_t answered, int64_t stamp, const wmr_moment *now);

/* Leaves at the next tick what a stop or a base too fast has latched; 0 while ~/stop says true: then it stays. */
int64_t wmr_filter_core_reset(wmr_filter_core *core);

#endif
