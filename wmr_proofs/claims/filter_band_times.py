"""The band of the command filter as a whole: its output at timely samples and at any time."""

import casadi as ca

from wmr_ctrl.control.filter.band import BandGovernor
from wmr_ctrl.control.filter.forecast import PAST, Fading, spread_of, stays_of
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.methods.spec import Z3
from wmr_proofs.statement import (
    Cuts,
    Relations,
    Statement,
    Symbols,
    between,
    nonnegative,
    symbols,
    within,
)

from .common import BOTH_AXES, elements_of
from .filter_assembled import STATED
from .filter_band import WAYS

claim = Claims(by=Z3())
BANDED = {
    "filter.kind": "band", "filter.loop": "second-order", "filter.damping": (0.5, 1.0),
    "filter.frequency": (4.0, 5.0), "filter.gain": STATED["filter.gain"], "clock.control": 0.1,
}  # fmt: skip
"""Settings for the structure of the band's graph; its numbers are symbols."""


def _whole(axis: int) -> tuple[BandGovernor, Symbols, Cuts]:
    """The band's graph, its inputs by name, and as cuts its ends and the remainder after a stop."""
    graph = BandGovernor(load_scenario("paper-simulation", BANDED))
    cuts = {f"end {i} {k}": end for i, pair in enumerate(graph.ends) for k, end in enumerate(pair)}
    cuts |= {f"stop {i}": most for i, most in enumerate(graph.stopping)} | {"sound": graph.sound}
    return graph, elements_of(*graph.system.inputs, graph.last), cuts


@claim(
    "filter.band.sent",
    each=BOTH_AXES,
)
def sent(mutation: Mutation, axis: int) -> Statement:
    """u_before - fall <= u <= u_before + rise, u what the whole band sends on each axis.

    Nothing bypasses the filter: no command and no scaling of the other axis.

    Given: {COMMANDS}, at any time; one factor for v and omega; parameters that are sound; 0 <= what
    a fall and a rise are admitted, and 0 <= the largest command behind which 0 may follow.
    """
    graph, named, cuts = _whole(axis)
    (low, high), u = graph.ends[axis], mutation(1, 1.1) * graph.sent[axis]
    ordered = tuple(most >= least for least, most in graph.ends)
    stops = nonnegative(*graph.stopping)
    given = ordered, stops, graph.sound == 1
    return Statement(named, (high >= u, u >= low), given, cuts)


@claim(
    "filter.band.sent-stop",
    each=BOTH_AXES,
)
def sent_stop(mutation: Mutation, axis: int) -> Statement:
    """|u| <= the largest command behind which 0 may follow, u what the whole band sends on each
    axis, and u never turns against what was asked for.

    Behind every command that is sent in time 0 may follow.

    Given: {COMMANDS}; one factor for v and omega; any parameters; 0 is between what a fall and a
    rise are admitted, and 0 <= the largest command behind which 0 may follow.
    """
    graph, named, cuts = _whole(axis)
    u = mutation(1, 1.1) * graph.sent[axis]
    around = [nonnegative(high, -low) for low, high in graph.ends]
    stops = nonnegative(*graph.stopping)
    goals = within(u, graph.stopping[axis]), u * graph.command[axis] >= 0
    return Statement(named, goals, (around, stops), cuts)


@claim(
    "filter.band.beat",
)
def beat(mutation: Mutation) -> Statement:
    """-before' <= p', q', 0 <= behind' and p' - q' <= before' + behind', the same after the next.

    Samples whose spread is within twice the jitter have one beat in common, whichever it is.

    Given: -before <= p, q <= behind, the times at which two samples came, less whole periods, after
    the last one; before, behind >= 0; the next one comes a period and ``off`` after that.
    """
    s = symbols("before behind off p q")
    after = spread_of(ca.vertcat(s.before, s.behind), s.off)
    p, q = (s[name] - mutation(1, 0.9) * s.off for name in ("p", "q"))
    given: list[Relations] = [nonnegative(s.before, s.behind)]
    goals: list[Relations] = [nonnegative(after[0], after[1]), ca.sum1(after) >= p - q]
    for name, own in (("p", p), ("q", q)):
        given.append(between(-s.before, s[name], s.behind))
        goals.append(between(-after[0], own, after[1]))
    return Statement(s, goals, given)


@claim(
    "filter.band.fading",
)
def fading(mutation: Mutation) -> Statement:
    """r g and p g, or r g alone where the sample is untimely, <= what is kept of them.

    How far the base is from its command is known whenever the next command comes.

    Given: r <= reach, p <= past; what stays of both is g >= 0, with g (1 + x + x^2/2) <= 1, x the
    rate times the time since the last sample, and g <= soonest where that came on its beat.
    """
    s = symbols("reach past held u came rate time soonest r p g")
    came, x = s.came, s.rate * s.time
    known = Fading(s.reach, s.past, s.held)
    after = known.aged(came, s.u, stays_of(s.rate, s.time), s.soonest)
    stays = s.g * (1 + x + 0.5 * x * x) <= 1, s.soonest >= came * s.g
    signs = nonnegative(came * (came - 1), came * (1 - came), s.g, s.rate, s.time, s.r, s.p)
    given = stays, signs, s.soonest >= 0, s.reach >= s.r, s.past >= s.p
    left = came * s.p + (1 - came) * s.r
    goals = after.reach >= mutation(1, 1.1) * s.r * s.g, after.past >= left * s.g
    return Statement(s, goals, given)


@claim(
    "filter.band.past",
    each=WAYS,
)
def past(mutation: Mutation, way: int) -> Statement:
    """v - held and held - v <= what is known of what was sent before, over and under its command.

    Behind an untimely sample nothing is lost of what is certain in any case.

    Given: c >= 0; v - held <= past; v <= c (1 + 2^-29), as long as the command stays held; under
    it, the same of -v and -held.
    """
    s = symbols("past held c v")
    bound = Fading(ca.SX(0), s.past, s.held).bounds(s.c)[0 if way > 0 else 1]
    v = way * (s.v - s.held)
    known = s.past >= mutation(1, 0.9) * v, PAST * s.c >= way * s.v
    return Statement(s, bound >= v, (known, nonnegative(s.c, v)))
