"""The command filter on bases that overshoot, and on bases whose wheels are not alike."""

import casadi as ca

from wmr_ctrl.control.filter.asked import JUST_ABOVE, for_base
from wmr_ctrl.control.filter.channels import WAYS
from wmr_ctrl.control.filter.clip import Clip
from wmr_ctrl.control.filter.governor_step import Governor
from wmr_ctrl.results.ledger import HAND
from wmr_ctrl.world.command_ramp import moved
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Z3
from wmr_proofs.relation import Relation, above, at_least, equal, nonnegative, within
from wmr_proofs.statement import Statement
from wmr_proofs.symbols import symbols

from .command_filter import COMMANDS
from .common import elements_of
from .filter_assembled import STATED

claim = Claims(by=Z3())
LINEAR = {"filter.kind": "clip", "filter.loop": "second-order", "filter.damping": (0.5, 1.0)}
"""Settings for the structure of the clip of linear loops; its numbers are symbols."""


@claim("filter.wheel-box", given="l > 0; |v + l omega|, |v - l omega| <= min(V, l Omega)")
def wheel_box(mutation: Mutation) -> Statement:
    """|v| <= V and |omega| <= Omega.

    Limits on each wheel alone keep the body's limits, however different the two wheels are.
    """
    t = symbols("v omega V Omega l", "V Omega l")
    top = mutation(1, 1.01) * ca.fmin(t.V, t.l * t.Omega)
    rims = [t.v + way * t.l * t.omega for way in WAYS]
    given = [above(t.l), *(part for rim in rims for part in within(rim, top))]
    goals = (*within(t.v, t.V), *within(t.omega, t.Omega))
    return Statement(t, goals, tuple(given))


COUNTING: dict[str, object] = {
    **STATED, "filter.delay": ((0.0, 0.03), (0.0, 0.13)), "clock.control": 0.05,
}  # fmt: skip
"""A governor whose commands may act for several periods, on one axis for longer."""


@claim(
    "filter.in-time",
    given="samples have come in time since one that did not, and the filter's count is that many, "
    "at most the commands that may act on either axis; the next comes in time or not",
)
def in_time(mutation: Mutation) -> Statement:
    """behind that one the count is as right, and the governor trusts its bounds where it is as many
    as the commands that may act.

    Behind a late sample the clip acts until every command that may still act was sent in time.
    """
    graph = Governor(load_scenario("paper-simulation", COUNTING))
    (count,) = list(graph.counted)
    most, came = graph.oldest, graph.came
    named = elements_of(graph.elapsed, count, *graph.p.ports) | symbols("since")
    since = named["since"]
    either = nonnegative(came * (came - 1), came * (1 - came))
    given = (at_least(since), equal(count.sym, ca.fmin(since, most)), *either)
    then = mutation(1, 2) * came * (since + 1)
    goals = (equal(graph.in_time[0], ca.fmin(then, most)), equal(graph.punctual, then >= most))
    return Statement(named, goals, given, {"came": came})


SMALL = STATED | {
    "filter.kind": "clip", "filter.scale": "axes", "base.deadband": (0.03, 0.3),
    "filter.least": True,
}  # fmt: skip
SLOW = LINEAR | {
    "filter.gain": STATED["filter.gain"], "filter.frequency": (4.0, 5.0),
    "filter.slew": (0.1, 0.1), "filter.scale": "axes",
}  # fmt: skip


@claim(
    "filter.least",
    given=f"{COMMANDS}; the limit (V - dbar)/K_max and b above 0; what was not sent of earlier "
    "commands within b, their way 1, -1 or 0; v and omega each by its own factor",
)
def least(mutation: Mutation) -> Statement:
    """the command that the whole clip sends with `filter.least` is within its limit on each axis
    and, where that is at least b, the least command that acts, it is 0 or no smaller than b; what
    was not sent stays within b.

    What is sent acts, is in the mean what was asked for, and is as safe as any other command.
    """
    clip = Clip(stated := load_scenario("paper-simulation", SMALL))
    graph = for_base(clip.system, stated)
    named = elements_of(*graph.inputs, *graph.state, *graph.params)
    given, goals, cuts = list[Relation](), list[Relation](), {"sound": clip.sound}
    rest, way = ca.vertsplit(graph.x, 2)
    for axis, limit in enumerate(clip.limits):
        band, w = named[f"base.deadband.{axis + 1}"] * JUST_ABOVE, way[axis]
        cuts[f"limit {axis}"], u = limit, graph.y[axis]
        idle = ca.if_else(band <= limit, u * (ca.fabs(u) < mutation(1, 1.1) * band), 0)
        given += above(band), above(limit), *within(rest[axis], band), equal(w * (w * w - 1))
        goals += *within(u, limit), *within(graph.update[axis], band), equal(idle)
    return Statement(named, tuple(goals), tuple(given), cuts)


@claim(
    "filter.ramp-rim",
    given="l > 0; changes in a step away from 0 and towards it: 0 <= grow <= l turn_back, 0 <= l "
    "turn <= shrink, of v grow and shrink, of omega turn and turn_back; |v + l omega|, |v - l "
    "omega| <= W of the ramped command and of the one that it nears",
)
def ramp_rim(mutation: Mutation) -> Statement:
    """The ramped command has |v + l omega|, |v - l omega| <= W after the step, too.

    Ramps on which each axis stops no slower than the other starts keep a limit of wheels.
    """
    t = symbols("v omega u w W l grow shrink turn turn_back", "W l grow shrink turn turn_back")
    l, pairs = t.l, ((t.v, t.omega), (t.u, t.w))
    v = moved(t.v, t.u, t.grow, t.shrink)
    omega = moved(t.omega, t.w, mutation(1, 1.5) * t.turn, t.turn_back)
    slower = at_least(l * t.turn_back, t.grow), at_least(t.shrink, l * t.turn)
    given = [above(l), *nonnegative(t.grow, t.turn), *slower]
    given += [r for x, y in pairs for way in WAYS for r in within(x + way * l * y, t.W)]
    goals = tuple(r for way in WAYS for r in within(v + way * l * omega, t.W))
    return Statement(t, goals, tuple(given))


@claim(
    "filter.peak-worst",
    given="K in (0, K_max], z >= z_min > 0; 0 < M, kp, ki and c >= 0 in their intervals",
    by=HAND,
)
def peak_worst() -> None:
    """N of second-order loops is largest at K_max and z_min, that of PI loops where kp is least, ki
    and M largest and c = 0, what a push leads to where kp, c, ki and M are least.

    The peak gain of a whole family is that of one corner, which is known beforehand.
    """


@claim(
    "filter.peak-gain",
    given="a linear loop of the family, its numbers constant, at rest at the start; |u| <= (V - "
    "delta)/N and |d| <= dbar, measurable functions of time",
    by=HAND,
    premises="filter.sent-clip.axes",
)
def peak_gain() -> None:
    """|v| <= N max|u| + delta <= V at every instant, N = int |g|, delta = int |g_d| dbar, for g and
    g_d the responses to an impulse of u and d.

    A clip at (V - delta)/N keeps a loop that overshoots within its limit, and no larger one does.
    """


@claim(
    "filter.command-error",
    given="as in filter.peak-gain, but what acts is off what was sent by at most d, a measurable "
    "function of time; delta + N d in place of delta",
    by=HAND,
    premises="filter.peak-gain",
)
def command_error() -> None:
    """|v| <= V at every instant, behind a clip, a clip of slow commands and a band alike: the loop
    is linear, so that the error adds a response of at most N d to that of what was sent.

    A base that rounds its commands keeps its limit for the price of N times half a step.
    """


@claim(
    "filter.slew",
    given="a linear loop of the family, its numbers constant, at rest at the start; |u| <= c; u "
    "changes by at most a times the time since the sample before, a T at most, or, where that is "
    "not told, by a T at samples T - jitter apart or more; commands take over in order, delays "
    "differ by at most s, at most n are lost in a row, H = (1 + n) (T + jitter) + s; |d| <= dbar; "
    "L as `swing` encloses it",
    by=HAND,
    premises="filter.peak-gain filter.slew-sent.together",
)
def slew() -> None:
    """|v| <= K c + a' (K L + N H/2) + delta <= V, a' = a T/(T - jitter), L the integral of |1 - S|
    from when S first reaches 1 on: what acts at two instants differs by at most a' (the time from
    one to the other + H), late or not, so that there is r with |r| <= c, |r'| <= a' and |u - r| <=
    a' H/2; before that instant r leads to at most K c, since S only rises there; after it, by
    parts, to at most K L a'.

    When commands change slowly, a linear loop overshoots by less than its peak gain allows for.
    """


@claim(
    "filter.held-loop",
    given="a PI loop of constant numbers whose force is held over steps h, friction too, at rest "
    "at the start; commands change at steps; h a < 2, h b < a, |w| h < 1 - h a/2 where w^2 < 0",
    by=HAND,
    premises="filter.peak-gain filter.slew filter.band.superposition",
)
def held_loop() -> None:
    """what is left of its steps, at each instant k h, is that of the loop with a', b', gamma'
    (`held_loop`), and the sum of h |1 - S| over instants at most its integral and h (N - 1).

    A filter that counts this loop beside its family keeps its limits in every step of a run.
    """
