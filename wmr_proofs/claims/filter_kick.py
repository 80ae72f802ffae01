"""Rims of a run's own base, whose loop compensates friction once per plant step."""

from collections.abc import Iterable, Iterator
from itertools import combinations, product

from casadi import SX, expm1, fmin, if_else, tanh, vertcat, vertsplit

from wmr_ctrl.control.filter import held_loop
from wmr_ctrl.control.filter.channels import WAYS
from wmr_ctrl.control.filter.governor import FirstOrder, largest_command
from wmr_ctrl.world.effect import Bound
from wmr_ctrl.world.model.dynamics import KEYS, plant, rk4_step, wheel_to_force
from wmr_ctrl.world.model.friction import friction, largest_slope
from wmr_ctrl.world.scenario import load_scenario
from wmr_ctrl.world.speed_loops import SPEED_LOOP
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import (
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

from .common import BOTH_AXES, PRESET, ports_of, scalars
from .wheels_and_encoders import EffectGraph

claim = Claims()
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


@claim(
    "filter.held-push",
    each=BOTH_AXES,
)
def held_push(mutation: Mutation, axis: int) -> Statement:
    """h (F + push - F1(v))/M = (1 - e)(K u + d - v) on each axis, F the force that the graph of
    the first-order loop gives for the command u + error, d the speed that counts for push and
    error.

    What filter.d has to cover: the speed at which pushes and errors of the command alone end.

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
    cuts = {"left1": fades[0], "left2": fades[1]}
    return g.states(goes == way, given=given, cuts=cuts, more=t)


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


@claim(
    "filter.held-friction",
    given=TANH.format("2.785", "the step's start to each stage"),
    premises="filter.held-push",
)
def held_friction(mutation: Mutation) -> Statement:
    """v1 goes in a Runge-Kutta step h of the plant by at least a share 1 - x/2 of h (F -
    F1(v1))/m, by at least none and at most all of it, x = h times F1's slope at rest over m.

    Friction that changes within a plant step makes v slower, no slower than a time constant tau'
    with exp(-h/tau') = 1 - (1 - exp(-h/tau))(1 - x/2), and throws it nowhere. Backwards by
    symmetry.
    """
    s = HeldStep(behind=False)
    moved, least = s.after - s.v, mutation(1, 1.01) * (1 - s.x / 2) * s.way
    changes = s.changes(product(("start",), STAGES))
    alike = [rise * (change - rise) >= 0 for rise, change in changes]
    goals = moved >= least, between(0, moved, s.way)
    return Statement(s.t, goals, (s.given, alike, s.x <= held_loop.STABLE), s.cuts)


@claim("filter.held-kick", given=TANH.format("2", "each of stages and v1 behind to each other"))
def held_kick(mutation: Mutation) -> Statement:
    """v1 goes in a Runge-Kutta step h of the plant less far than h (F - F1(v1))/m, by at most h/m
    times the rise of F1 from the step's start to its end.

    Friction held over steps takes v off its loop's way by no more, in all, than h times its range
    while v nears a command from one side. Backwards by symmetry.
    """
    s = HeldStep(behind=True)
    most = mutation(1, 0.9) * s.h * (s.friction(s.after) - s.friction(s.v)) / s.m
    alike = list[Relations]()
    for rise, change in s.changes(combinations(s.at, 2)):
        for side, on in ((1, change >= 0), (-1, change < 0)):
            alike += when(on, between(0, side * rise, side * change))
    missed = between(0, s.way - (s.after - s.v), most)
    return Statement(s.t, missed, (s.given, alike, s.x <= 2), s.cuts)


class Command(Named):
    """A rim of a first-order base while one command acts, with the effect of friction.

    ``gone`` is the share of its way that the loop has covered. Friction causes at most the
    deviation ``kick``, of which it may still cause ``credit`` at the start and ``left`` now.
    """

    def __init__(self, mutation: Mutation) -> None:
        """Create the symbols; friction counts as a push that causes the kick in the least time."""
        fixed = "gone_least gone_most V d K_max kick"
        self.symbols = t = symbols(f"start bound asked gone credit left {fixed}", fixed)
        self.push = held_loop.push_of_kick(mutation(1, 0.9) * t.kick, t.gone_least)
        kappa = 1 / t.gone_most - 1
        unused, d = SX(0), t.d + self.push
        limits = FirstOrder(t.V, d, unused, unused, t.K_max, kappa)
        self.given: Relations = (
            positive(t.V, t.K_max, t.gone_least), between(0, t.left, t.credit),
            t.kick >= t.credit, t.d >= 0, d < t.V, t.gone_most <= 1,
            t.gone_most >= t.gone_least, between(0, t.gone, t.gone_most),
            largest_command(t.bound, limits) >= t.asked, between(t.start, t.bound, t.V),
            t.start + t.credit <= t.V,
        )  # fmt: skip

    def reached(self, start: SX, push: SX, gone: SX) -> SX:
        """Speed after the loop has covered the share ``gone`` of its way."""
        return (1 - gone) * start + gone * (self.K_max * self.asked + push)


@claim(
    "filter.held-rim",
    premises="filter.held-kick",
)
def held_rim(mutation: Mutation) -> Statement:
    """where v falls towards the command, the rim stays within V by what friction may still lead to;
    where it does not, within V, and from the shortest time of a command on by all that friction may
    lead to. From then on what the governor carries from one takeover, or from V or odometry in
    between, to the next bounds the rim's speed there, of odometry that may be off by what friction
    leads to, too.

    What friction took from v's way at a rim it cannot take again before v has risen, and there it
    only holds the rim back. The governor's bound is right wherever it counts, though not within the
    time of a command.

    Given: a command within the governor's, with kappa = 0 the clip's, whose push is d and what is
    for friction; it acts while the loop goes at most what kappa counts on; the speed at the start
    within the bound that the governor counts on and, by what friction may still lead to, within V.
    """
    t = Command(mutation)
    true, enough = t.reached(t.start, t.d, t.gone), t.gone >= t.gone_least
    carried = t.reached(t.bound, t.d + t.push, t.gone)
    seen = t.reached(fmin(t.start + t.kick, t.V), t.d + t.push, t.gone)
    goals = (
        true + t.credit <= t.V,
        true + if_else(enough, t.kick, 0) <= t.V,
        if_else(enough, carried - (true + t.kick), 0) >= 0,
        seen >= true + t.credit,
    )
    return t.states(goals, given=t.given)


@claim(
    "filter.held-share",
    premises="filter.held-friction filter.held-push filter.clip",
)
def held_share(mutation: Mutation) -> Statement:
    """|v|, |v + l omega| and |v - l omega| keep V and W behind the step, d the push that counts for
    x and V.

    Behind a clip a wheel that stops for a turn keeps its limit although friction holds back v.

    Given: l, V, W > 0; 0 <= x <= 2, 0 <= q <= 1; |v| <= V and |v + l omega|, |v - l omega| <= W,
    and the same, less d, of the speeds to which command and pushes lead; of q times its way v goes
    a share from 1 - x/2 to 1, and omega all.
    """
    t = symbols("v omega to turn_to share held q V W l", "held V W l")
    d = held_loop.push_of_share(2 * mutation(1, 0.9) * t.held, t.V)  # x/2 is held
    after = t.v + t.share * t.q * (t.to - t.v), t.omega + t.q * (t.turn_to - t.omega)

    def inside(v: SX, omega: SX, less: SX) -> Relations:
        rims = (v + way * t.l * omega for way in WAYS)
        return within(v, t.V - less), [within(rim, t.W - less) for rim in rims]

    shares = between(0, t.held, 1), between(1 - t.held, t.share, 1), between(0, t.q, 1)
    before = inside(t.v, t.omega, SX(0)), inside(t.to, t.turn_to, d)
    given = positive(t.l, t.V, t.W), shares, before
    return Statement(t, inside(*after, SX(0)), given)
