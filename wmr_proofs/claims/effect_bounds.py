"""Bounds of effects, on their own graphs: drives, ground, air, sensors, commands in transit to a
base.
"""

from collections.abc import Mapping
from dataclasses import replace

from casadi import SX, cos, exp, expm1, floor, fmin, if_else, is_equal, sin, vertcat, vertsplit

from wmr_ctrl.control.applied import followed
from wmr_ctrl.control.guard.delay import integral, moved
from wmr_ctrl.world import (
    command_delay,
    command_loss,
    command_quantum,
    delay,
    encoder,
    gust,
    gyro,
    jitter,
    lag,
    motor,
    push,
    resistance,
    slope,
    torque_noise,
    velocity_mean,
    velocity_noise,
    wheel_commands,
    wheels,
)
from wmr_ctrl.world.effect import ROUNDING, Bound, Effect
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_ctrl.world.model.system import Parameters
from wmr_ctrl.world.scenario import load_scenario
from wmr_proofs.claim import Claims, Mutation, rows
from wmr_proofs.methods.spec import Z3
from wmr_proofs.regions import at
from wmr_proofs.statement import (
    UNIT,
    Cuts,
    Group,
    Named,
    Relations,
    Statement,
    at_least,
    between,
    equal,
    every,
    exchanged,
    nonnegative,
    positive,
    symbols,
    when,
    within,
)
from wmr_proofs.traced import Tracing, expression, functions_for_traced, traced

from .common import ports_of, scalars

WHEELS = {"wheels.radius": [0.01, -0.01], "wheels.track": 0.01}
"""Structure of the graphs alone: their numbers stay symbols."""


class EffectGraph(Named):
    """An effect's System for a scenario with some numbers, which stay symbols.

    ``symbols``: all ports' elements by name, and the numbers that the bound alone reads;
    ``parameters``: the graph's own by their keys.
    """

    def __init__(self, effect: Effect, numbers: Mapping[str, object], tables: str = "") -> None:
        """Take the bound's numbers of ``tables`` and of its own section as symbols."""
        self.effect, self.scenario = effect, load_scenario("paper-simulation", numbers)
        self.system = effect.build(self.scenario)
        self.parameters = Parameters(self.scenario, self.system.params)
        self.tables = tuple(dict.fromkeys((effect.section.KEY, *tables.split())))
        self.told, self.trace = self._bounded(1.0)
        drawn = (item.port for item in self.system.draws)
        ports = (*ports_of(self.system), *drawn)
        self.symbols = self.trace.symbols | scalars(ports)

    def _bounded(self, share: float) -> tuple[Bound, Tracing]:
        scenario, trace = traced(self.scenario, self.tables, share)
        assert self.effect.bound is not None
        with functions_for_traced("wmr_ctrl.world", but="wmr_ctrl.world.effect"):
            return self.effect.bound(scenario), trace

    @property
    def torque(self) -> SX:
        """Torques that are asked for."""
        return vertcat(self["tau_right"], self["tau_left"])

    def column(self, name: str) -> SX:
        """The two elements ``name[1]`` and ``name[2]``."""
        return vertcat(self[f"{name}[1]"], self[f"{name}[2]"])

    def bound(self, name: str) -> SX:
        """The pair or number ``name`` of the effect's Bound, for the symbols of its graph.

        Conditions that its code tests on the way become part of the claim (`states`). ValueError if
        it depends on a number that is no symbol.
        """
        pairs = []
        for told, trace in ((self.told, self.trace), self._bounded(1.25)):
            value = vars(told)[name]
            pair = value if isinstance(value, tuple) else (value,)
            found = vertcat(*map(expression, pair), *trace.met)
            pairs.append(exchanged(found, trace.symbols, self))
        if not is_equal(pairs[0], pairs[1], 100):
            raise ValueError(f"the bound of {self.effect.name} holds a number that is no symbol")
        parts = vertsplit(pairs[0])
        self.always = [at_least(item, 1) for item in parts[len(pair) :]]
        return vertcat(*parts[: len(pair)])

    def above_zero(self, *names: str) -> Relations:
        """Each of these numbers is positive."""
        return [self[name] > 0 for name in names]


MISREAD = "|c - 1| u1 + |d| l' u2", "|c l'/l - 1| u2 + |d| u1/l"
MISMADE = "tau sum |1/(1 + radius_i) - 1|/r", "l tau sum |(1 + track)/(1 + radius_i) - 1|/r"

wheels_claim = Claims()


@wheels_claim(
    "world.encoder.{name}",
    over=rows(axis=(0, 1), name=("v1", "omega"), error=("2 pi r/(N w)", "2 pi r/(N w l)")),
)
def counted_speed(mutation: Mutation, axis: int) -> Statement:
    """differences of counts over w, the window that the bound gives, give {name} with an error
    below {error}.

    The window that the guard assumes, and an encoder's contribution to nbar.

    Given: {WHOLE}.
    """
    g = EffectGraph(encoder.ENCODER, {"encoder.counts": 64.0}, "robot clock")
    now = encoder.turned(g.scenario, g.parameters, g["path"], g["theta"] + g["skid"])
    turn = symbols("old_right old_left")
    old = vertcat(turn.old_right, turn.old_left)
    whole = g.column("wheel_counts_1")
    given = Group()
    for real, part in ((now, floor(now)), (old, whole)):
        for i in (0, 1):
            given += real[i] >= part[i], real[i] - part[i] < 1
    exact = encoder.velocity_of((now - old) / g["clock.control"], g.parameters)
    bound = g.bound("nbar")[axis]
    off = g.system.outputs[axis].expr - exact[axis]
    most = mutation(bound, 0.9 * bound)
    sides = g.above_zero("robot.r", "robot.l", "encoder.counts", "clock.control", "sample")
    cuts = {"turn_right": now[0], "turn_left": now[1]}
    cuts |= {"counts_right": floor(now[0]), "counts_left": floor(now[1])}
    window = g.bound("window")[axis] == g["clock.control"]
    goals = most > off, off > -most, window
    return g.states(goals, given=(sides, given), cuts=cuts, more=turn)


def _shares(g: EffectGraph) -> Relations:
    """1 + radius_i and 1 + track are positive."""
    return positive(*(1 + g[f"wheels.{name}"] for name in ("radius[1]", "radius[2]", "track")))


@wheels_claim(
    "world.wheels.misread-{name}",
    over=rows(axis=(0, 1), name=("v1", "omega"), off=MISREAD),
)
def misread_speed(mutation: Mutation, axis: int) -> Statement:
    """if the wheels differ from the believed ones, their rotation gives {name} with an error of at
    most {off}, where c and d are the mean and half the difference of 1/(1 + radius_i).

    Contribution of wrong radii to nbar of an encoder.

    Given: {WHEELS_INSIDE}.
    """
    numbers = {"encoder.counts": 64.0, **WHEELS}
    g, t = EffectGraph(encoder.ENCODER, numbers, "robot clock wheels limits"), symbols("v omega")
    turn = encoder.turned(g.scenario, g.parameters, t.v, t.omega)
    limits = g.column("limits.v_u1")
    believed = g["robot.r"], g["robot.l"]
    counted = encoder.rounded_by(believed, g["encoder.counts"], g["clock.control"])[axis]
    most = g.bound("nbar")[axis] - counted
    off = encoder.velocity_of(turn, g.parameters)[axis] - (t.v if axis == 0 else t.omega)
    sizes = g.above_zero("robot.r", "robot.l", "encoder.counts", "clock.control")
    given = sizes, _shares(g), within(vertcat(*t.values()), limits), positive(limits[0], limits[1])
    return g.states(within(off, most * mutation(1, 0.9)), given=given, more=t)


@wheels_claim(
    "world.wheels.{name}",
    over=rows(axis=(0, 1), name=("thrust", "moment"), off=MISMADE),
)
def wheels_thrust(mutation: Mutation, axis: int) -> Statement:
    """for torques of at most tau the error of the {name} is at most {off}.

    Contribution of wrong radii, and for the moment of a wrong track, to dbar.

    Given: {WHEELS_SIZES}.
    """
    g = EffectGraph(wheels.WHEELS, {**WHEELS, "actuator.tau_max": 5.0}, "robot actuator motor")
    told = g.torque
    believed = (g["robot.r"], g["robot.l"])
    made, meant = (wheel_to_force(*believed, tau)[axis] for tau in (g.system.y, told))
    bound = g.bound("dbar")[axis]
    sizes = within(told, g["actuator.tau_max"] + 0.5 * g["motor.step"])
    given = g.above_zero("robot.r", "robot.l"), _shares(g), sizes
    return g.states(within(made - meant, bound * mutation(1, 0.9)), given=given)


drive_claim = Claims()


@drive_claim("world.lag.stepped")
def held(mutation: Mutation) -> Statement:
    """a lag that holds a plant step's last value adds h Z1 + s Z1, at most the contribution of a Z
    that rises with a = h e/(1 - e) and falls with b, and ends no higher, for every s in [a, b].

    A lag computed in plant steps is covered by one with a slightly smaller time constant.

    Given: e = exp(-h/tau_min); tau_min <= tau <= b, exponentials as symbols with exp(-h/a) <=
    exp(-h/tau_min) <= exp(-h/tau) <= exp(-h/b) < 1 and h <= b (exp(h/b) - 1).
    """
    # One plant step of the lag that holds its value, and Z that the guard follows.
    t = symbols("z p step share growth b between least falls rises")
    z, p, h, s, growth, b, e, least, falls, rises = t.values()
    a, after = lag.equivalent_lag(h, growth), lag.followed(p, e, z)
    guarded = integral(z, p, (h, b * (1 - falls), a * (1 - rises)))
    end = moved(z, p, (falls, rises))
    goals = guarded + s * end >= (mutation(1, 1.01) * h + s) * after, end >= after
    given = (
        nonnegative(z, p), positive(h, growth), between(a, s, b),
        least * (1 + growth) == 1, between(0, rises, least), between(least, e, falls),
        falls < 1, b * (1 - falls) >= h * falls,
    )  # fmt: skip
    return Statement(t, goals, given)


@drive_claim("world.lag.applied")
def applied(mutation: Mutation) -> Statement:
    """the applied torque in a law's input is the mean of the torques that acted in the plant steps
    of the sample behind delay and lag, and the torque at its end is that of the drives.

    The observer and the monitor use the torque that the simulated drives produced.

    Given: 0 < e < 1 for e = exp(-h/lag); four plant steps in a period, delay of one period and
    three steps.
    """
    t, steps, part = symbols("newest older oldest acting e"), 4, 3
    newest, older, oldest, acting, e = t.values()
    told = followed([newest, older, oldest], (1, part, steps), acting, e)
    total = SX(0)
    for step in range(steps):
        acting = lag.followed(oldest if step < part else older, e, acting)
        total = total + acting
    goals = told[0] == mutation * total / steps, told[1] == acting
    return Statement(t, goals, (e > 0, e < 1))


@drive_claim("world.lag.bound")
def lag_bound(mutation: Mutation) -> Statement:
    """on the drives' own graph a share exp(-h/tau) of the acting torque is left after a step, tau =
    lag (1 + spread x), |x| <= 1, which is at most the upper time constant in their bound, and
    h/(exp(h/tau) - 1) of it at least the lower one.

    Contribution of drives with a varying lag to the guard's numbers (see also world.lag.stepped).

    Given: {TIMES}: larger where lag' is smaller, exp(x) - 1 >= x.
    """
    numbers = {"actuator.lag": 0.02, "actuator.lag_spread": 0.2}
    g, t = EffectGraph(lag.LAG, numbers, "clock"), symbols("growth most_growth decay")
    h, time = g["clock.plant"], g["actuator.lag"]
    x, spread = g[f"{lag.NUMBERS.name}[1]"], g["actuator.lag_spread"]
    fast, slow = vertsplit(g.bound("lag"))
    tau = time * (1 + spread * x)
    sizes = g.above_zero("clock.plant", "actuator.lag", "actuator.lag_spread"), spread < 1
    steps = [most * time * (1 - spread) >= h for most in (t.most_growth, 500)]
    given = sizes, steps, within(x, 1), t.growth > 0, t.most_growth >= t.growth
    left = every(g.system.update, g.torque + t.decay * (g.column(lag.ACTING.name) - g.torque))
    goals = mutation(1, 0.9) * slow >= tau, lag.equivalent_lag(h, t.growth) >= fast, left
    cuts = {"most_growth": expm1(h / (time * (1 - spread))), "decay": exp(-h / tau)}
    return g.states(goals, given=given, cuts=cuts, more=t)


@drive_claim("world.lag.constant")
def constant_lag(mutation: Mutation) -> Statement:
    """both time constants in the bound of a lag without spread are the lag of the drives' own
    graph, where the share exp(-h/lag) remains after a step.

    Contribution of drives with one time constant to the guard's numbers.

    Given: lag > 0, spread = 0.
    """
    g = EffectGraph(lag.LAG, {"actuator.lag": 0.02}, "clock")
    time = g["actuator.lag"]
    t, cuts = symbols("decay"), {"decay": exp(-g["clock.plant"] / time)}
    both = [told == mutation * time for told in vertsplit(g.bound("lag"))]
    goals = (
        both,
        every(g.system.update, g.torque + t.decay * (g.column(lag.ACTING.name) - g.torque)),
    )
    return g.states(goals, given=(time > 0, g["actuator.lag_spread"] == 0), cuts=cuts, more=t)


@drive_claim("world.delay.bound")
def delay_bound(mutation: Mutation) -> Statement:
    """the bound of the delay equals the delay of a command in the drives' own graph: delay +
    unmodelled delay.

    The latest takeover that the guard assumes.

    Given: any delay and unmodelled delay.
    """
    g = EffectGraph(delay.DELAY, {"actuator.delay": 0.02, "actuator.unmodelled_delay": 0.01})
    assert g.system.transport is not None
    return g.states(g.bound("delay")[0] == mutation * g.system.transport)


class Jittering(EffectGraph):
    """Drives with jitter: steps of a period, largest jitter, draws and phase are ``free``."""

    def __init__(self) -> None:
        super().__init__(jitter.JITTER, {"actuator.jitter": 0.01})
        self.free, h = symbols("steps most drawn phase"), self["clock.plant"]
        times = self["clock.control"], self["actuator.jitter"]
        steps, most = (jitter.whole(time / h) for time in times)
        late = self["actuator.delay"] + self["actuator.unmodelled_delay"]
        since = self["step"] - jitter.whole(late / h)
        self.cuts = {
            "steps": steps, "most": most, "phase": since - steps * floor(since / steps),
            "drawn": floor((self[f"{jitter.NUMBERS.name}[1]"] + 1) / 2 * (most + 1)),
        }  # fmt: skip


@drive_claim("world.jitter.bound")
def jitter_bound(mutation: Mutation) -> Statement:
    """in the drives' own graph a command that arrived at phase 0 acts from phase jitter/h on at the
    latest, and times drawn for the next steps are at most that; the bound has this jitter.

    The earliest and the latest takeover that the guard assumes.

    Given: jitter a multiple of h, h > 0; drawn, a whole number from 0 on, below jitter/h + 1, so at
    most jitter/h; the waiting command's time was drawn in the same way.
    """
    g = Jittering()
    h, width, t = g["clock.plant"], g["actuator.jitter"], g.free
    now, _, wait = vertsplit(g.system.update, [0, 2, 4, 5])
    waits = t.most >= g[jitter.DUE.name], nonnegative(t.phase, t.steps)
    given = h > 0, width == t.most * h, width >= 0, between(0, t.drawn, t.most), waits
    acts = t.phase >= mutation(t.most, t.most - 1)
    told = [g.bound(name)[0] == width for name in ("delay", "jitter")]
    goals = when(acts, every(now, g.torque)), t.most >= wait, told
    return g.states(goals, given=given, cuts=g.cuts, more=t)


@drive_claim("world.motor.step")
def stepped(mutation: Mutation) -> Statement:
    """torque in steps has an error of at most half a step.

    Contribution of a motor's resolution to dbar.

    Given: step > 0.
    """
    g = EffectGraph(motor.MOTOR, {"motor.step": 0.1})
    told, step = g["tau_right"], g["motor.step"]
    x = told / step + 0.5
    number = floor(x)
    given = step > 0, x >= number, x - number < 1
    lost = within(g.system.outputs[0].expr - told, motor.rounded_by(step) * mutation(1, 0.8))
    return g.states(lost, given=given, cuts={"number": number})


@drive_claim("world.motor.dead-zone")
def world_motor_dead_zone(mutation: Mutation) -> Statement:
    """a dead zone removes at most its width, in the torque's direction.

    Its contribution to dbar.

    Given: zone > 0.
    """
    g = EffectGraph(motor.MOTOR, {"motor.dead_zone": 0.1})
    told, zone = g["tau_right"], g["motor.dead_zone"]
    lost = told - g.system.outputs[0].expr
    goals = within(lost, mutation(zone, 0.9 * zone)), lost * told >= 0
    return g.states(goals, given=zone > 0)


@drive_claim("world.motor.line")
def line(mutation: Mutation) -> Statement:
    """on the torque-speed line a torque up to tau misses at most the smaller of tau and d(s) =
    max(tau - stall (1 - s/free), 0), s the speed in its direction, if positive.

    The torque that a motor lacks at a speed.

    Given: stall > 0, 1/free >= 0, |torque| <= tau.
    """
    t = symbols("torque speed stall slowing most", "stall slowing")
    torque, speed, stall, slowing, most = t.values()
    made = motor.on_line(torque, speed, stall, slowing)
    share = slowing * speed
    ahead, back = (motor.missing(most, stall, way * share) for way in (1, -1))
    ahead, back = fmin(ahead, most), fmin(back, most)
    part = mutation(1, 0.9)
    sides = part * ahead >= torque - made, part * back >= made - torque
    goals = sides, (torque - made) * torque >= 0
    given = stall > 0, slowing >= 0, within(torque, most)
    return Statement(t, goals, given)


@drive_claim(
    "world.motor.{name}",
    over=rows(way=(1, -1), name=("thrust", "moment"), drive=("one way", "opposite ways")),
)
def pair_ahead(mutation: Mutation, way: int) -> Statement:
    """d(s) of both wheels together is largest at v1 = u1, |omega| = u2 where they drive {drive}.

    Contribution of motors to dbar, {name}.

    Given: |v1| <= u1, l |omega| <= l u2; stall > 0, 1/free >= 0.
    """
    t = symbols("v turn u1 edge stall slowing most", "stall slowing")

    def both(v: SX, turn: SX) -> SX:
        speeds = (v + turn, v - turn) if way > 0 else (turn + v, turn - v)
        first, second = (motor.missing(t.most, t.stall, t.slowing * s) for s in speeds)
        return first + second

    limited = positive(t.u1, t.edge), within(t.v, t.u1), within(t.turn, t.edge)
    given = t.stall > 0, t.slowing >= 0, limited
    return Statement(t, both(mutation(t.u1, 0.9 * t.u1), t.edge) >= both(t.v, t.turn), given)


@drive_claim(
    "world.motor.bound-{name}",
    premises="world.motor.step world.motor.dead-zone world.motor.line world.motor.{name}",
    over=rows(axis=(0, 1), name=("thrust", "moment")),
)
def motor_bound(mutation: Mutation, axis: int) -> Statement:
    """the torque that motors lack causes at most the {name} of their bound, for steps, dead zone
    and line together.

    The guard's bound for motors covers the sum of their parts.

    Given: step, zone, stall, free, tau_max, r, l, u1, u2 > 0; |tau_i| <= tau_max; |v1| <= u1,
    |omega| <= u2; each wheel misses at most half a step, the zone, and the smaller of d of its
    speed and tau_max + step/2; d of both wheels as world.motor.{name} has it.
    """
    numbers = {
        "motor.step": 0.1, "motor.dead_zone": 0.1, "motor.stall": 3.0, "motor.free": 9.0,
        "actuator.tau_max": 4.0,
    }  # fmt: skip
    g = EffectGraph(motor.MOTOR, numbers, "robot limits actuator")
    t, bound = symbols("right left"), g.bound("dbar")[axis]
    r, half, stall, step = (g[n] for n in ("robot.r", "robot.l", "motor.stall", "motor.step"))
    most, slowing = g["actuator.tau_max"] + step / 2, 1 / g["motor.free"]

    def short(v: SX, turn: SX, sides: tuple[int, int]) -> list[SX]:
        return [motor.missing(most, stall, side * (v + way * turn) / r * slowing)
                for side, way in zip(sides, (1, -1), strict=True)]  # fmt: skip

    signs = "motor.dead_zone", "actuator.tau_max", "limits.v_u1[1]", "limits.v_u1[2]"
    given = [g.above_zero("robot.r", "robot.l", "motor.free", "motor.stall", "motor.step", *signs)]
    ends = (g["limits.v_u1[1]"], half * g["limits.v_u1[2]"])
    opposite = 1 if axis == 0 else -1
    for side in (1, -1):
        each = short(g["v1"], half * g["omega"], (side, side * opposite))
        given.append(at_least(sum(short(*ends, (1, opposite))), sum(each)))
        for name, d, way in zip(t, each, (side, side * opposite), strict=True):
            lost = motor.rounded_by(step) + g["motor.dead_zone"] + fmin(d, most)
            given.append(lost >= way * t[name])
    made = wheel_to_force(r, half, vertcat(t.right, t.left))[axis]
    return g.states(within(made, bound * mutation(1, 0.9)), given=given, more=t)


ALONG = at(
    **{"robot.m": 1, "guard.M_max[1]": 1, "robot.g": 1},
    sine=1,
    **{"slope.offset": 0},
    along=1,
    across=0,
)
"""Straight uphill."""

claim = Claims()


@claim("world.slope", by=Z3(points=(ALONG,)))
def world_slope(mutation: Mutation) -> Statement:
    """a slope pulls with at most m g sin(angle), and turns with at most |offset| times that.

    Contribution of a slope to dbar.

    Given: 0 < m <= guard.M_max, g > 0, sin(angle) >= 0; |sine|, |cosine| of the heading <= 1.
    """
    g = EffectGraph(slope.SLOPE, {"slope.angle": 0.1, "guard.M_max": [60.0, 20.0]}, "robot guard")
    a = slope.turned(g["theta"], g["slope.direction"])
    along, across, sine = cos(a), sin(a), sin(g["slope.angle"])
    goals = within(g.system.y, mutation(1, 0.9) * g.bound("dbar"))
    turns = sine >= 0, within(vertcat(along, across), 1)
    given = g.above_zero("robot.m", "robot.g"), g["guard.M_max[1]"] >= g["robot.m"], turns
    return g.states(goals, given=given, cuts={"along": along, "across": across, "sine": sine})


@claim(
    "world.resistance.{name}",

    over=(
        {"name": "thrust", "axis": 0, "sign": "v1", "pair": "+", "does": "drives", "times": ""},
        {"name": "moment", "axis": 1, "sign": "omega", "pair": "-", "does": "turns",
         "times": "l times "},
    ),
)  # fmt: skip
def resisted_thrust(mutation: Mutation, axis: int) -> Statement:
    """rolling resistance {does} the robot on with at most {times}the difference of the wheels'.

    Equal wheels only brake; the excess of one wheel may push.  Backwards by symmetry.

    Given: {HEAVY}; {sign} >= 0; |tanh| <= 1, and as {sign} >= 0 has it tanh((v1 + l omega)/v_s)
    {pair} tanh((v1 - l omega)/v_s) >= 0.
    """
    numbers = {"resistance.rolling": [0.01, 0.02], "guard.M_max": [60.0, 20.0]}
    g = EffectGraph(resistance.RESISTANCE, numbers, "robot guard")
    v, omega = g["v1"], g["omega"]
    right, left = resistance.smoothed(v, g["robot.l"] * omega, g["robot.v_s"])
    load = resistance.load_of_wheel(g["robot.m"], g["robot.g"])
    rolling = (g["resistance.rolling[1]"], g["resistance.rolling[2]"])
    more = g.bound("dbar")[axis]
    moves = right + left if axis == 0 else right - left
    sizes = g.above_zero("robot.l", "robot.g", "robot.m"), g["guard.M_max[1]"] >= g["robot.m"]
    turns = (v, omega)[axis] >= 0, within(vertcat(right, left), 1)
    given = nonnegative(*rolling, g[f"resistance.viscous[{axis + 1}]"], load, moves), sizes, turns
    goal = more * mutation(1, 0.9) >= g.system.y[axis]
    return g.states(goal, given=given, cuts={"right": right, "left": left})


@claim(
    "world.noise.{name}",
    over=rows(axis=(0, 1), name=("thrust", "moment"), most=("2 n std/r", "2 l n std/r")),
)
def noise_thrust(mutation: Mutation, axis: int) -> Statement:
    """torque noise within n std on each wheel causes a {name} of at most {most}.

    Contribution of torque noise to dbar.

    Given: r, l > 0, std >= 0; |each normal number| <= n.
    """
    g = EffectGraph(torque_noise.TORQUE_NOISE_EFFECT, {"disturbance.truncate": 5.0}, "robot")
    believed = (g["robot.r"], g["robot.l"])
    bound = g.bound("dbar")[axis]
    force = wheel_to_force(*believed, g.system.y)[axis]
    drawn = within(g.column("torque"), g["disturbance.truncate"])
    given = g.above_zero("robot.r", "robot.l"), g["disturbance.std"] >= 0, drawn
    return g.states(within(force, bound * mutation(1, 0.9)), given=given)


@claim("world.gust")
def world_gust(mutation: Mutation) -> Statement:
    """a filter's share of the size stays within [-1, 1], and the force within the size.

    Contribution of gusts to dbar.

    Given: shares before and numbers within [-1, 1], size >= 0, 0 <= keep = exp(-T/time) <= 1.
    """
    g = EffectGraph(gust.GUST, {"gust.size": [1.0, 1.0]})
    keep = exp(-g["clock.control"] / g["gust.time"])
    size, part = g.bound("dbar"), mutation(1, 0.9)
    drawn = vertcat(g.column(gust.SHARE.name), g.column(gust.NUMBERS.name))
    pairs = zip(*map(vertsplit, (g.system.update, g.system.y, part * size)), strict=True)
    goals = [(within(x, part), within(y, most)) for x, y, most in pairs]
    sides = between(0, keep, 1), nonnegative(size[0], size[1])
    return g.states(goals, given=(within(drawn, 1), sides), cuts={"keep": keep})


@claim("world.gyro")
def world_gyro(mutation: Mutation) -> Statement:
    """a gyro has an error of at most |bias| + noise.

    Its contribution to nbar.

    Given: noise >= 0; the random number within [-1, 1].
    """
    g = EffectGraph(gyro.GYRO, {"gyro.enabled": True})
    most = g.bound("nbar")[1] * mutation(1, 0.9)
    given = g["gyro.noise"] >= 0, within(g[f"{gyro.NUMBERS.name}[1]"], 1)
    return g.states(within(g.system.y[0] - g["omega"], most), given=given)


@claim("world.velocity-noise")
def world_velocity_noise(mutation: Mutation) -> Statement:
    """noise of the velocity is at most its half-width, per axis.

    Its contribution to nbar.

    Given: half-widths >= 0; random numbers within [-1, 1].
    """
    g = EffectGraph(velocity_noise.VELOCITY_NOISE, {})
    half = g.bound("nbar")
    goals = within(g.system.y - g.system.u, mutation(1, 0.9) * half)
    drawn = within(g.column(velocity_noise.NUMBERS.name), 1)
    return g.states(goals, given=(drawn, nonnegative(*vertsplit(half))))


AGES = {"sensor.velocity_window": 0.02, "sensor.velocity_age": 0.01, "clock.control": 0.01}


@claim("world.velocity-mean.bound")
def world_velocity_mean(mutation: Mutation) -> Statement:
    """the mean velocity times the window in its bound is the distance from that window's start to
    its end, and both have the ages in the bound, in periods since each distance was read.

    The age and the window that the guard assumes.

    Given: T > 0; a window of two periods that ended one period ago, after the first sample.
    """
    g = EffectGraph(velocity_mean.VELOCITY_MEAN, AGES, "clock limits")
    T, name = g["clock.control"], velocity_mean.PLACE.name
    seen = [g.column(f"{name}_{k}") for k in (1, 2, 3)]
    goals: list[Relations] = [every(g.system.update, vertcat(g["path"], g["theta"], *seen[:2]))]
    for axis in (0, 1):
        window, age = (g.bound(told)[axis] for told in ("window", "age"))
        way = seen[0][axis] - mutation(seen[2], seen[1])[axis]
        goals += [g.system.y[axis] * window == way, age == T, window == 2 * T]
    return g.states(goals, given=g.above_zero("clock.control", "sample"))


@claim(
    "world.velocity-mean.rounding{of}",
    over=rows(axis=(0, 1), of=("", "-angular"), what=("velocity", "angular velocity")),
)
def rounded_mean(mutation: Mutation, axis: int) -> Statement:
    """the computed mean {what} differs from that of the exact path length by at most the error in
    its bound.

    Contribution of a mean to nbar: the rounding of path lengths.

    Given: u1, h > 0; a window of two periods T, T at least h, ended one period ago, after the first
    sample; its way is at most u1 times the window, and the duration no shorter and eight h or more;
    |path|, |theta| <= u1 duration, so that rounding in each h of the window makes 2^-53 u1
    duration/h times the window at most.
    """
    g = EffectGraph(velocity_mean.VELOCITY_MEAN, AGES, "clock limits")
    t, name = symbols("way shown"), velocity_mean.PLACE.name
    h, lasts, u1 = g["clock.plant"], g["clock.duration"], g[f"limits.v_u1[{axis + 1}]"]
    window = 2 * g["clock.control"]
    missed = g[f"{name}_1[{axis + 1}]"] - g[f"{name}_3[{axis + 1}]"] - t.way
    times = between(2 * h, window, lasts), lasts >= 8 * h
    ways = within(t.way, u1 * window), within(h * missed, UNIT * u1 * lasts * window)
    given = g.above_zero("clock.plant", "sample"), u1 > 0, times, ways
    most = mutation(1, 0.4) * g.bound("nbar")[axis]
    whole = g.states(within(t.shown * window - t.way, most * window), given=given, more=t)
    return replace(whole, computed={"shown": g.system.y[axis]})


@claim("world.push")
def world_push(mutation: Mutation) -> Statement:
    """an adversary's push is at most its size, per axis.

    Its contribution to dbar.

    Given: r, l > 0, size >= 0; at every velocity.
    """
    g = EffectGraph(push.PUSH, {"disturbance.push": [1.0, 1.0]})
    size = g.bound("dbar")
    force = wheel_to_force(g["robot.r"], g["robot.l"], g.system.y)
    sides = g.above_zero("robot.r", "robot.l"), nonnegative(size[0], size[1])
    return g.states(within(force, mutation(1, 0.9) * size), given=sides)


command_claim = Claims()


@command_claim("world.command-delay.bound")
def command_delay_bound(mutation: Mutation) -> Statement:
    """the bound of a command's delay equals the delay in its own graph, which leaves the command
    unchanged.

    The delay of a command that the governor assumes.

    Given: any delay.
    """
    g = EffectGraph(command_delay.COMMAND_DELAY, {"base.delay": 0.02})
    assert g.system.transport is not None
    late = g.bound("delay")[0] == mutation * g.system.transport
    return g.states(late, every(g.system.y, g.system.u))


@command_claim("world.command-loss.bound")
def command_loss_bound(mutation: Mutation) -> Statement:
    """the number of consecutive lost commands is at most that in the bound, silence lasts for the
    lost periods and no longer, and the base never stops in between.

    The number of lost commands that the governor assumes.

    Given: losses >= 0 whole, timeout at least (losses + 1) T less 1e-9 of it, which is at most h; T
    a multiple of h > 0; until now no more were lost in a row than the bound says, and silence lasts
    for the lost periods.
    """
    numbers = {"base.losses": 2, "base.timeout": 0.05, "clock.control": 0.01}
    g = EffectGraph(command_loss.COMMAND_LOSS, numbers, "clock")
    t = symbols("steps phase before")
    h, T, most = g["clock.plant"], g["clock.control"], g.bound("losses")[0]
    steps = jitter.whole(T / h)
    since = g["step"] - jitter.whole(g["base.delay"] / h)
    cuts = {"steps": steps, "phase": since - steps * floor(since / steps)}
    longest = (g["base.losses"] + 1) * T
    missed, silent = g[command_loss.MISSED.name], g[command_loss.SILENT.name]
    given = (
        h > 0, equal(T, t.steps * h), g["base.losses"] >= 0, t.steps >= 1,
        g["base.timeout"] >= longest * (1 - ROUNDING), h >= longest * ROUNDING,
        between(0, missed, most), nonnegative((most - missed) * (most - missed - 1), t.before),
        t.steps >= t.before + 1, silent >= 0,
        t.phase == if_else(t.before + 1 >= t.steps, 0, t.before + 1),
        (t.steps - t.before - 1) * (t.steps - t.before - 2) >= 0,
        missed * t.steps + t.before >= silent,
    )  # fmt: skip
    now, silence, missing = vertsplit(g.system.update, [0, 2, 3, 4])
    few = mutation(1, 0.9) * most >= missing
    goals = few, missing * t.steps + t.phase >= silence, every(g.system.y, now)
    return g.states(goals, given=given, cuts=cuts, more=t)


@command_claim("world.command-quantum.bound")
def command_quantum_bound(mutation: Mutation) -> Statement:
    """a rounded command has an error of at most half a step, per axis.

    The error of a command that the governor assumes.

    Given: step > 0; whole parts of two numbers: n <= x < n + 1.
    """
    g = EffectGraph(command_quantum.COMMAND_QUANTUM, {"base.quantum": [0.01, 0.01]})
    off, most, given = g.system.y - g.system.u, g.bound("command"), Group()
    cuts = Cuts()
    for i in (0, 1):
        step = g[f"base.quantum[{i + 1}]"]
        x = g.system.u[i] / if_else(step > 0, step, 1) + 0.5
        cuts[f"number{i + 1}"] = number = floor(x)
        given += [step > 0, x >= number, x - number < 1]
    return g.states(within(off, mutation(1, 0.9) * most), given=given, cuts=cuts)


@command_claim("world.wheel-commands")
def wheels_heard(mutation: Mutation) -> Statement:
    """behind dead bands of the wheels the error of the acting command is at most command + dropped
    of the bound, and the acting command exceeds the one that arrived by at most command, per axis.

    The error of a command that a filter and a clip assume.

    Given: l > 0, size >= 0; no ramps.
    """
    g = EffectGraph(wheel_commands.WHEEL_COMMANDS, {"base.wheel_deadband": 0.03}, "robot")
    error, dropped = mutation(1, 0.9) * g.bound("command"), g.bound("dropped")
    u, acts = g.system.u, g.system.y
    goals = within(acts - u, error + dropped), within(acts, abs(u) + error)
    return g.states(goals, given=(g.above_zero("robot.l"), g["base.wheel_deadband"] >= 0))
