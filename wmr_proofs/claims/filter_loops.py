"""The command filter on bases that overshoot, and on bases with unequal wheels.  Also rims of a
simulated base, whose loop compensates friction once per plant step.
"""

from collections.abc import Iterable, Iterator
from itertools import combinations, product

from casadi import SX, expm1, fmin, if_else, tanh, vertcat, vertsplit

from wmr_ctrl.control.filter import held_loop
from wmr_ctrl.control.filter.asked import JUST_ABOVE, for_base
from wmr_ctrl.control.filter.channels import WAYS
from wmr_ctrl.control.filter.clip import Clip, swung
from wmr_ctrl.control.filter.governor import FirstOrder, largest_command
from wmr_ctrl.control.filter.governor_step import Governor
from wmr_ctrl.world.command_ramp import moved
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.model.dynamics import KEYS, plant, rk4_step, wheel_to_force
from wmr_ctrl.world.model.friction import friction, largest_slope
from wmr_ctrl.world.scenario import load_scenario
from wmr_ctrl.world.speed_loops import SPEED_LOOP
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import (
    Group,
    Named,
    Relations,
    Statement,
    Symbols,
    between,
    exchanged,
    nonnegative,
    positive,
    symbols,
    when,
    within,
)
from wmr_proofs.traced import Traced, expression, functions_for_traced, traced

from .command_filter import STATED, Keys
from .common import BOTH_AXES, PRESET, elements_of, ports_of, scalars
from .effect_bounds import EffectGraph

claim = Claims()
LINEAR: Keys = {
    "filter.kind": "clip", "filter.loop": "second-order", "filter.damping": (0.5, 1.0),
}  # fmt: skip
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


class Swung(Named):
    """A linear loop's numbers, the rooms U and D of both directions, and the commands a and b."""

    def __init__(self) -> None:
        self.symbols = t = symbols("N least most U D P Q", "N least most")
        numbers = t.N, t.least, t.most
        self.cuts = {"a": swung(*numbers, t.U, t.D), "b": swung(*numbers, t.D, t.U)}
        self.given: Relations = (
            t.least > 0, t.most >= t.least, t.most <= t.N, nonnegative(t.U, t.D, t.P, t.Q),
        )  # fmt: skip

    def lines(self, command: SX, own: SX, other: SX, more: float = 1) -> Relations:
        """Conditions on a command with the room ``own``, each without a quotient."""
        N, least, most = self.N, self.least, self.most
        swing = (N + if_else(own >= other, least, most)) * (own - other)
        both = N * (least + most) * command <= more * ((least + most) * other + swing)
        alone = (N + most) * command <= 2 * own, (N - least) * command <= 2 * other
        return command >= 0, alone, when(command > 0, both)


@claim("filter.swung.lines")
def swung_lines(mutation: Mutation) -> Statement:
    """a >= 0, (N + most) a <= 2 U, (N - least) a <= 2 D and, if a > 0, N (least + most) a <= (least
    + most) D + (N + gain) (U - D), gain = least for U >= D and most else, a what the clip leaves.

    Conditions on a command in one direction of a loop that overshoots.

    Given: 0 < least <= most <= N, the rooms U, D >= 0.
    """
    s = Swung()
    return s.states(s.lines(s.cuts["a"], s.U, s.D, mutation(1, 0.9)), given=s.given)


@claim("filter.swung", premises="filter.swung.lines")
def swings(mutation: Mutation) -> Statement:
    """P a + Q b <= U, with the clip's largest commands a and b for the rooms U and D of both
    directions.

    In a loop that overshoots, a command in one direction also causes speed in the other; with U and
    D exchanged this is the other direction.

    Given: 0 < least <= most <= N, U, D >= 0; P, Q >= 0, P + Q <= N, least <= P - Q <= most.
    """
    s = Swung()
    a, b = s.cuts.values()
    lines = s.lines(a, s.U, s.D), s.lines(b, s.D, s.U)
    given = s.given, lines, s.P + s.Q <= s.N, between(s.least, s.P - s.Q, mutation(1, 1.5) * s.most)
    return s.states(s.P * a + s.Q * b <= s.U, given=given, cuts=s.cuts)


COUNTING: dict[str, Keys] = {
    "delay": {"filter.delay": ((0.0, 0.03), (0.0, 0.13))},
    "losses": {"filter.losses": 2},
    "late": {"filter.delay": (0.0, 0.03), "filter.losses": 1, "filter.jitter": 0.01,
             "filter.age": 0.08, "filter.hold": 0.2},
}  # fmt: skip
"""Times of a governor whose commands may act for several periods, in one on an axis for longer."""


@claim("filter.in-time", each={name: {"more": more} for name, more in COUNTING.items()})
def in_time(mutation: Mutation, more: Keys) -> Statement:
    """the count is also right after the next sample, and the governor takes all commands that may
    act for punctual exactly if the count equals their number.

    After a late sample the clip acts until every command that may still act was punctual.

    Given: the filter's count is the number of samples that came in time since one that did not, at
    most that of the commands that may act on either axis; the next sample comes in time or not.
    """
    graph = Governor(load_scenario("paper-simulation", STATED | {"clock.control": 0.05} | more))
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


@claim("filter.least")
def least(mutation: Mutation) -> Statement:
    """the command that the whole clip sends with `filter.least` is within its limit on each axis.
    If that limit is at least b, the least command that acts, the command is 0 or no smaller than b,
    and the sum not sent stays within b.

    If the limit admits b, each command that is sent has an effect, and small ones equal the request
    on average; all are as safe as other commands.

    Given: {COMMANDS}; the limit (V - dbar)/K_max, V less 2^-26 of it, one for both directions, and
    b, `base.deadband` and 2^-26 of it, above 0; the unsent sum of earlier commands within b, their
    sign 1, -1 or 0; v and omega each by its own factor, no dead band of the wheels; {PLAIN}.
    """
    clip = Clip(stated := load_scenario("paper-simulation", SMALL))
    graph = for_base(clip.system, stated)
    named = elements_of(*ports_of(graph))
    given, goals, cuts = Group(), Group(), {"sound": clip.sound}
    rest, way = vertsplit(graph.x, 2)
    for axis, limit in enumerate(clip.limits):
        band, w = named[f"base.deadband.{axis + 1}"] * JUST_ABOVE, way[axis]
        cuts[f"limit {axis}"], u = limit, graph.y[axis]
        idle = if_else(band <= limit, u * (abs(u) < mutation(1, 1.1) * band), 0)
        given += positive(band, limit), within(rest[axis], band), w * (w * w - 1) == 0
        goals += within(u, limit), within(graph.update[axis], band), idle == 0
    return Statement(named, goals, given, cuts)


@claim("filter.ramp-rim")
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
    return Statement(t, [within(v + way * l * omega, t.W) for way in WAYS], given)


kick_claim = Claims()
STAGES = ("half", "again", "end")
BASE = {"base.kind": "velocity", "changes": ()}


def pushed(g: EffectGraph) -> tuple[SX, Symbols]:
    """Both axes' `push_speeds` of a graph's base, for symbols of pushes and errors."""
    scenario, trace = traced(g.scenario, ("base", "robot", "clock"))
    told = symbols("push1 push2 error1 error2")
    push, error = ([Traced(1.0, told[f"{name}{i}"], trace) for i in (1, 2)]
                   for name in ("push", "error"))  # fmt: skip
    with functions_for_traced("wmr_ctrl.control.filter", but="wmr_ctrl.control.filter.hypotheses"):
        off = Bound(dbar=(push[0], push[1]), command=(error[0], error[1]))
        speeds = held_loop.push_speeds(scenario, off)
    return exchanged(vertcat(*map(expression, speeds)), trace.symbols, g), told


@kick_claim("filter.held-push", each=BOTH_AXES)
def held_push(mutation: Mutation, axis: int) -> Statement:
    """h (F + push - F1(v))/M = (1 - e)(K u + d - v) on each axis, with F the force of the
    first-order loop's graph for the command u + error, and d the equivalent speed of push and
    error.

    The speed that filter.d has to cover: the steady speed due to pushes and command errors alone.

    Given: m, I, r, l, v_s, h, tau > 0, e = exp(-h/tau) < 1; no wheel at its torque limit.
    """
    g = EffectGraph(SPEED_LOOP, BASE, "robot clock")
    d, t = pushed(g)
    m, inertia, mu, r, l, gravity, v_s = (g[key] for key in KEYS)
    h, most, v = g["clock.plant"], g["actuator.tau_max"], vertcat(g["v1"], g["omega"])
    force = wheel_to_force(r, l, g.system.y) - friction(mu, m, gravity, v_s, v)
    tau = vertsplit(g.column("base.tau"))
    fades = [expm1(-h / time) for time in tau]
    asked = g.system.u[axis] - t[f"error{axis + 1}"]
    goes = h * (force[axis] + mutation * t[f"push{axis + 1}"]) / (m, inertia)[axis]
    way = -fades[axis] * (g[f"base.gain[{axis + 1}]"] * asked + d[axis] - v[axis])
    weak = [most > side * g.system.y[i] for i in (0, 1) for side in (1, -1)]
    given = positive(m, inertia, r, l, v_s, h, *tau, *(-left for left in fades)), weak
    return g.states(goes == way, given=given, cuts={"left1": fades[0], "left2": fades[1]}, more=t)


class HeldStep:
    """A Runge-Kutta step h of the plant: v1 after it and at its stages, and its way under constant
    friction.

    ``at`` are these speeds; friction's tanh at each is a symbol of the same name.
    """

    def __init__(self, behind: bool) -> None:
        """Name the numbers; with ``behind`` the speed after the step is a symbol, too."""
        self.robot = robot = plant(load_scenario(PRESET))
        t = scalars(ports_of(robot)) | symbols("step", "step")
        self.m, _, self.mu, r, l, self.g, self.v_s = (t[key] for key in KEYS)
        tau = vertcat(t.tau_right + t.noise_right, t.tau_left + t.noise_left)
        force, self.v, self.h = wheel_to_force(r, l, tau)[0] + t.thrust, t.v1, t.step
        self.after = rk4_step(robot, self.h)[3]
        self.way = self.h * (force - self.friction(self.v)) / self.m
        self.at = {"start": self.v} | dict(zip(STAGES, self.stages(), strict=True))
        self.at |= {"after": self.after} if behind else {}
        self.t = t | symbols(" ".join(self.at))
        self.cuts = {name: tanh(v / self.v_s) for name, v in self.at.items()} | {"force": force}
        self.given = positive(self.m, self.g, self.v_s, self.h), nonnegative(self.mu, self.way)

    def changes(self, pairs: Iterable[tuple[str, str]]) -> Iterator[tuple[SX, SX]]:
        """Change of friction's tanh from one speed to another, and that of its argument."""
        for one, other in pairs:
            yield self.t[other] - self.t[one], (self.at[other] - self.at[one]) / self.v_s

    @property
    def x(self) -> SX:
        """Friction's pace."""
        slope = largest_slope(self.mu, self.m, self.g, self.v_s)
        return held_loop.pace_of_friction(self.h, slope, self.m)

    def friction(self, v: SX) -> SX:
        """F1 at a speed."""
        return friction(self.mu, self.m, self.g, self.v_s, vertcat(v, 0))[0]

    def stages(self) -> Iterator[SX]:
        """v1 at each further stage."""
        robot, h = self.robot, self.h
        rate, x = robot.function("rate", [robot.update]), robot.x
        for part in (h / 2, h / 2, h):
            x = robot.x + part * rate(robot.u, x, robot.p)
            yield x[3]


TANH = (
    "m, g, v_s, h > 0, mu >= 0; x <= {}; F the force of loop and pushes, with h (F - F1(v1))/m >= "
    "0; tanh changes as its argument, by no more, from {} "
)


@kick_claim(
    "filter.held-friction",
    given=TANH.format("2.785", "the step's start to each stage"),
    premises="filter.held-push",
)
def held_friction(mutation: Mutation) -> Statement:
    """in a Runge-Kutta step h of the plant v1 changes by at least a share 1 - x/2 of h (F -
    F1(v1))/m, by a share between 0 and 1 in any case; x = h times F1's slope at rest over m.

    Friction that changes within a plant step slows v, by no more than a time constant tau' with
    exp(-h/tau') = 1 - (1 - exp(-h/tau))(1 - x/2), and never makes it overshoot.  Backwards by
    symmetry.
    """
    s = HeldStep(behind=False)
    moved, least = s.after - s.v, mutation(1, 1.01) * (1 - s.x / 2) * s.way
    changes = s.changes(product(("start",), STAGES))
    alike = [rise * (change - rise) >= 0 for rise, change in changes]
    goals = moved >= least, between(0, moved, s.way)
    return Statement(s.t, goals, (s.given, alike, s.x <= held_loop.STABLE), s.cuts)


@kick_claim(
    "filter.held-kick", given=TANH.format("2", "each of stages and v1 behind to each other")
)
def held_kick(mutation: Mutation) -> Statement:
    """in a Runge-Kutta step h of the plant v1 changes by at most h (F - F1(v1))/m; the difference
    is at most h/m times the rise of F1 from the step's start to its end.

    While v approaches a command from one side, friction held over steps causes a total deviation of
    v from its loop of at most h times friction's range.  Backwards by symmetry.
    """
    s = HeldStep(behind=True)
    most = mutation(1, 0.9) * s.h * (s.friction(s.after) - s.friction(s.v)) / s.m
    alike = Group()
    for rise, change in s.changes(combinations(s.at, 2)):
        for side, on in ((1, change >= 0), (-1, change < 0)):
            alike += when(on, between(0, side * rise, side * change))
    missed = between(0, s.way - (s.after - s.v), most)
    return Statement(s.t, missed, (s.given, alike, s.x <= 2), s.cuts)


class Command(Named):
    """A rim of a first-order base while one command acts, with the effect of friction.

    ``gone`` is the share of its change that the loop has made.  Friction causes at most the
    deviation ``kick``, of which it may still cause ``credit`` at the start and ``left`` now.
    """

    def __init__(self, mutation: Mutation) -> None:
        """Create the symbols; friction counts as a push that causes the kick in the least time."""
        fixed = "gone_least gone_most V d K_max kick"
        self.symbols = t = symbols(f"start bound asked gone credit left {fixed}", fixed)
        self.push = held_loop.push_of_kick(mutation(1, 0.9) * t.kick, t.gone_least)
        unused, d = SX(0), t.d + self.push
        limits = FirstOrder(t.V, d, unused, unused, t.K_max, 1 / t.gone_most - 1)
        self.given: Relations = (
            positive(t.V, t.K_max, t.gone_least), between(0, t.left, t.credit),
            t.kick >= t.credit, t.d >= 0, d < t.V, t.gone_most <= 1,
            t.gone_most >= t.gone_least, between(0, t.gone, t.gone_most),
            largest_command(t.bound, limits) >= t.asked, between(t.start, t.bound, t.V),
            t.start + t.credit <= t.V,
        )  # fmt: skip

    def reached(self, start: SX, push: SX, gone: SX) -> SX:
        """Speed after the loop has made the share ``gone`` of its change."""
        return (1 - gone) * start + gone * (self.K_max * self.asked + push)


@kick_claim("filter.held-rim", premises="filter.held-kick")
def held_rim(mutation: Mutation) -> Statement:
    """if v falls towards the command, the rim stays within V with a margin for the deviation that
    friction may still cause.  Otherwise it stays within V, and from the shortest time of a command
    on with a margin for all that friction may cause.  From then on the governor's propagated bound,
    from a takeover, from V or from odometry, bounds the rim's speed at the next takeover, also if
    odometry has the error that friction causes.

    A deviation that friction has caused at a rim cannot occur again before v has risen, and then
    friction only slows the rim.  The governor's bound is right at every takeover, though not within
    the time of a command.

    Given: a command within the governor's limit (the clip's for kappa = 0), whose push is d plus
    the part for friction; it acts for at most the time that kappa assumes; the speed at the start
    is within the bound that the governor uses and within V, with a margin for the deviation that
    friction may still cause.
    """
    t = Command(mutation)
    true, enough = t.reached(t.start, t.d, t.gone), t.gone >= t.gone_least
    goals = (
        true + t.credit <= t.V,
        true + if_else(enough, t.kick, 0) <= t.V,
        if_else(enough, t.reached(t.bound, t.d + t.push, t.gone) - (true + t.kick), 0) >= 0,
        t.reached(fmin(t.start + t.kick, t.V), t.d + t.push, t.gone) >= true + t.credit,
    )
    return t.states(goals, given=t.given)


@kick_claim("filter.held-share", premises="filter.held-friction filter.held-push filter.clip")
def held_share(mutation: Mutation) -> Statement:
    """|v|, |v + l omega| and |v - l omega| stay within V and W after the step, with d the push
    equivalent to x and V.

    Behind a clip a wheel that stops for a turn keeps its limit although friction holds back v.

    Given: l, V, W > 0; 0 <= x <= 2, 0 <= q <= 1; |v| <= V and |v + l omega|, |v - l omega| <= W,
    and the steady speeds of command and pushes are within these less d; v covers a share from 1 -
    x/2 to 1 of q times its change, and omega all of it.
    """
    t = symbols("v omega to turn_to share held q V W l", "held V W l")
    d = held_loop.push_of_share(2 * mutation(1, 0.9) * t.held, t.V)  # x/2 is held
    after = t.v + t.share * t.q * (t.to - t.v), t.omega + t.q * (t.turn_to - t.omega)

    def inside(v: SX, omega: SX, less: SX) -> Relations:
        rims = (v + way * t.l * omega for way in WAYS)
        return within(v, t.V - less), [within(rim, t.W - less) for rim in rims]

    shares = between(0, t.held, 1), between(1 - t.held, t.share, 1), between(0, t.q, 1)
    given = positive(t.l, t.V, t.W), shares, inside(t.v, t.omega, SX(0)), inside(t.to, t.turn_to, d)
    return Statement(t, inside(*after, SX(0)), given)
