"""The command filter on bases that overshoot, and on bases whose wheels are not alike."""

from casadi import fmin, if_else, vertsplit

from wmr_ctrl.control.filter.asked import JUST_ABOVE, for_base
from wmr_ctrl.control.filter.channels import WAYS
from wmr_ctrl.control.filter.clip import Clip
from wmr_ctrl.control.filter.governor_step import Governor
from wmr_ctrl.world.command_ramp import moved
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import Relations, Statement, nonnegative, positive, symbols, within

from .common import elements_of, ports_of
from .filter_assembled import STATED

claim = Claims()
LINEAR = {"filter.kind": "clip", "filter.loop": "second-order", "filter.damping": (0.5, 1.0)}
"""Settings for the structure of the clip of linear loops; its numbers are symbols."""


@claim("filter.wheel-box")
def wheel_box(mutation: Mutation) -> Statement:
    """|v| <= V and |omega| <= Omega.

    Limits on each wheel alone keep the body's limits, however different the two wheels are.

    Given: l > 0; |v + l omega|, |v - l omega| <= min(V, l Omega).
    """
    t = symbols("v omega V Omega l", "V Omega l")
    v, omega, V, Omega, l = t.values()
    top = mutation(1, 1.01) * fmin(V, l * Omega)
    rims = [v + way * l * omega for way in WAYS]
    given = l > 0, [within(rim, top) for rim in rims]
    goals = within(v, V), within(omega, Omega)
    return Statement(t, goals, given)


COUNTING: dict[str, object] = {
    **STATED, "filter.delay": ((0.0, 0.03), (0.0, 0.13)), "clock.control": 0.05,
}  # fmt: skip
"""A governor whose commands may act for several periods, on one axis for longer."""


@claim(
    "filter.in-time",
)
def in_time(mutation: Mutation) -> Statement:
    """behind that one the count is as right, and the governor trusts its bounds where it is as many
    as the commands that may act.

    Behind a late sample the clip acts until every command that may still act was sent in time.

    Given: samples have come in time since one that did not, and the filter's count is that many, at
    most the commands that may act on either axis; the next comes in time or not.
    """
    graph = Governor(load_scenario("paper-simulation", COUNTING))
    (count,) = list(graph.counted)
    most, came = graph.oldest, graph.came
    named = elements_of(graph.elapsed, count, *graph.p.ports) | symbols("since")
    since = named["since"]
    either = nonnegative(came * (came - 1), came * (1 - came))
    given = since >= 0, count.sym == fmin(since, most), either
    then = mutation(1, 2) * came * (since + 1)
    goals = graph.in_time[0] == fmin(then, most), graph.punctual == (then >= most)
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
)
def least(mutation: Mutation) -> Statement:
    """the command that the whole clip sends with `filter.least` is within its limit on each axis
    and, where that is at least b, the least command that acts, it is 0 or no smaller than b; what
    was not sent stays within b.

    What is sent acts, is in the mean what was asked for, and is as safe as any other command.

    Given: {COMMANDS}; the limit (V - dbar)/K_max and b above 0; what was not sent of earlier
    commands within b, their way 1, -1 or 0; v and omega each by its own factor.
    """
    clip = Clip(stated := load_scenario("paper-simulation", SMALL))
    graph = for_base(clip.system, stated)
    named = elements_of(*ports_of(graph))
    given, goals, cuts = list[Relations](), list[Relations](), {"sound": clip.sound}
    rest, way = vertsplit(graph.x, 2)
    for axis, limit in enumerate(clip.limits):
        band, w = named[f"base.deadband.{axis + 1}"] * JUST_ABOVE, way[axis]
        cuts[f"limit {axis}"], u = limit, graph.y[axis]
        idle = if_else(band <= limit, u * (abs(u) < mutation(1, 1.1) * band), 0)
        given += positive(band, limit), within(rest[axis], band), w * (w * w - 1) == 0
        goals += within(u, limit), within(graph.update[axis], band), idle == 0
    return Statement(named, goals, given, cuts)


@claim(
    "filter.ramp-rim",
)
def ramp_rim(mutation: Mutation) -> Statement:
    """The ramped command has |v + l omega|, |v - l omega| <= W after the step, too.

    Ramps on which each axis stops no slower than the other starts keep a limit of wheels.

    Given: l > 0; changes in a step away from 0 and towards it: 0 <= grow <= l turn_back, 0 <= l
    turn <= shrink, of v grow and shrink, of omega turn and turn_back; |v + l omega|, |v - l omega|
    <= W of the ramped command and of the one that it nears.
    """
    t = symbols("v omega u w W l grow shrink turn turn_back", "W l grow shrink turn turn_back")
    l, pairs = t.l, ((t.v, t.omega), (t.u, t.w))
    v = moved(t.v, t.u, t.grow, t.shrink)
    omega = moved(t.omega, t.w, mutation(1, 1.5) * t.turn, t.turn_back)
    slower = l * t.turn_back >= t.grow, t.shrink >= l * t.turn
    kept = [within(x + way * l * y, t.W) for x, y in pairs for way in WAYS]
    given = l > 0, nonnegative(t.grow, t.turn), slower, kept
    goals = [within(v + way * l * omega, t.W) for way in WAYS]
    return Statement(t, goals, given)
