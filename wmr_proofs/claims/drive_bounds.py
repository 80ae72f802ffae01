"""Drives: what lag, delay, jitter and motors add to the guard's assumptions, on their graphs."""

import casadi as ca

from wmr_ctrl.control.applied import followed
from wmr_ctrl.control.guard.delay import integral, moved
from wmr_ctrl.world import delay, jitter, lag, motor
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_proofs.claim import Claims, Mutation, rows
from wmr_proofs.methods.spec import Z3
from wmr_proofs.statement import (
    Statement,
    at_least,
    between,
    every,
    nonnegative,
    positive,
    symbols,
    when,
    within,
)

from .wheels_and_encoders import EffectGraph

claim = Claims(by=Z3())


@claim(
    "world.lag.stepped",
)
def held(mutation: Mutation) -> Statement:
    """a lag that holds a plant step's last value adds h Z1 + s Z1 <= what Z adds that rises with a
    = h e/(1 - e) and falls with b, and ends no higher, for every s in [a, b].

    A lag computed in plant steps counts as one with a slightly smaller time constant.

    Given: e = exp(-h/tau_min); tau_min <= tau <= b, exponentials as symbols with exp(-h/a) <=
    exp(-h/tau_min) <= exp(-h/tau) <= exp(-h/b) < 1 and h <= b (exp(h/b) - 1).
    """
    # One plant step of the lag that holds its value, and Z that the guard follows.
    t = symbols("z p step share growth b between least falls rises")
    z, p, h, s, growth, b, e, least, falls, rises = t.values()
    a, after = lag.equivalent_lag(h, growth), lag.followed(p, e, z)
    guarded = integral(z, p, (h, b * (1 - falls), a * (1 - rises)))
    end = moved(z, p, (falls, rises))
    adds = guarded + s * end >= (mutation(1, 1.01) * h + s) * after
    goals = adds, end >= after
    given = (
        nonnegative(z, p), positive(h, growth), between(a, s, b),
        least * (1 + growth) == 1, between(0, rises, least), between(least, e, falls),
        falls < 1, b * (1 - falls) >= h * falls,
    )  # fmt: skip
    return Statement(t, goals, given)


@claim(
    "world.lag.applied",
)
def applied(mutation: Mutation) -> Statement:
    """the torque that laws are told was applied is the mean of what acted in the plant steps of the
    sample behind delay and lag, and what acts at its end is the drives' own.

    The observer and the monitor use the torque that the simulated drives produced.

    Given: 0 < e < 1 for e = exp(-h/lag); four plant steps in a period, delay of one period and
    three steps.
    """
    t, steps, part = symbols("newest older oldest acting e"), 4, 3
    newest, older, oldest, acting, e = t.values()
    told = followed([newest, older, oldest], (1, part, steps), acting, e)
    total = ca.SX(0)
    for step in range(steps):
        acting = lag.followed(oldest if step < part else older, e, acting)
        total = total + acting
    goals = told[0] == mutation * total / steps, told[1] == acting
    return Statement(t, goals, (e > 0, e < 1))


@claim("world.lag.bound")
def lag_bound(mutation: Mutation) -> Statement:
    """on the drives' own graph a share exp(-h/tau) of the acting torque is left after a step, tau =
    lag (1 + spread x), |x| <= 1, which is at most the upper time constant in their bound, and
    h/(exp(h/tau) - 1) of it at least the lower one.

    What drives of a lag that varies add to the guard's numbers (world.lag.stepped has the rest).

    Given: {TIMES}: larger where lag' is smaller, exp(x) - 1 >= x.
    """
    numbers = {"actuator.lag": 0.02, "actuator.lag_spread": 0.2}
    g, t = EffectGraph(lag.LAG, numbers, "clock"), symbols("growth most_growth decay")
    h, time = g["clock.plant"], g["actuator.lag"]
    x, spread = g[f"{lag.NUMBERS.name}[1]"], g["actuator.lag_spread"]
    fast, slow = ca.vertsplit(g.bound("lag"))
    tau = time * (1 + spread * x)
    sizes = g.above_zero("clock.plant", "actuator.lag", "actuator.lag_spread"), spread < 1
    steps = [most * time * (1 - spread) >= h for most in (t.most_growth, 500)]
    given = sizes, steps, within(x, 1), t.growth > 0, t.most_growth >= t.growth
    least = lag.equivalent_lag(h, t.growth)
    wanted = ca.vertcat(g["tau_right"], g["tau_left"])
    acting = g.column(lag.ACTING.name)
    left = every(g.system.update, wanted + t.decay * (acting - wanted))
    goals = mutation(1, 0.9) * slow >= tau, least >= fast, left
    cuts = {"most_growth": ca.expm1(h / (time * (1 - spread))), "decay": ca.exp(-h / tau)}
    return g.states(goals, given=given, cuts=cuts, more=t)


@claim("world.lag.constant")
def constant_lag(mutation: Mutation) -> Statement:
    """both time constants that the bound of a lag without spread tells are the lag of the drives'
    own graph, of which exp(-h/lag) is left in a step.

    What drives of one time constant add to the guard's numbers.

    Given: lag > 0, spread = 0.
    """
    g = EffectGraph(lag.LAG, {"actuator.lag": 0.02}, "clock")
    time = g["actuator.lag"]
    wanted = ca.vertcat(g["tau_right"], g["tau_left"])
    acting = g.column(lag.ACTING.name)
    t, cuts = symbols("decay"), {"decay": ca.exp(-g["clock.plant"] / time)}
    both = [told == mutation * time for told in ca.vertsplit(g.bound("lag"))]
    goals = both, every(g.system.update, wanted + t.decay * (acting - wanted))
    return g.states(goals, given=(time > 0, g["actuator.lag_spread"] == 0), cuts=cuts, more=t)


@claim("world.delay.bound")
def delay_bound(mutation: Mutation) -> Statement:
    """the bound of the delay is what the drives' own graph holds a command back by: delay +
    unmodelled delay.

    What the guard counts as the latest takeover.

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
        number = self[f"{jitter.NUMBERS.name}[1]"]
        late = self["actuator.delay"] + self["actuator.unmodelled_delay"]
        since = self["step"] - jitter.whole(late / h)
        self.cuts = {
            "steps": steps, "most": most, "phase": since - steps * ca.floor(since / steps),
            "drawn": ca.floor((number + 1) / 2 * (most + 1)),
        }  # fmt: skip


@claim(
    "world.jitter.bound",
)
def jitter_bound(mutation: Mutation) -> Statement:
    """in the drives' own graph a command that arrived at phase 0 acts from phase jitter/h on at the
    latest, and what is drawn for the next steps is at most that; this jitter is the one in the
    bound.

    What the guard counts as the earliest and the latest takeover.

    Given: jitter a multiple of h, h > 0; drawn, a whole number from 0 on, below jitter/h + 1, so at
    most jitter/h; what waits was drawn like that.
    """
    g = Jittering()
    h, width, t = g["clock.plant"], g["actuator.jitter"], g.free
    now, _, wait = ca.vertsplit(g.system.update, [0, 2, 4, 5])
    widths = h > 0, width == t.most * h, width >= 0, between(0, t.drawn, t.most)
    waits = t.most >= g[jitter.DUE.name], nonnegative(t.phase, t.steps)
    given = widths, waits
    arrived = ca.vertcat(g["tau_right"], g["tau_left"])
    acts = t.phase >= mutation(t.most, t.most - 1)
    told = [g.bound(name)[0] == width for name in ("delay", "jitter")]
    goals = when(acts, every(now, arrived)), t.most >= wait, told
    return g.states(goals, given=given, cuts=g.cuts, more=t)


@claim("world.motor.step")
def stepped(mutation: Mutation) -> Statement:
    """torque in steps is off by at most half a step.

    What a motor's resolution adds to dbar.

    Given: step > 0.
    """
    g = EffectGraph(motor.MOTOR, {"motor.step": 0.1})
    told, step = g["tau_right"], g["motor.step"]
    x = told / step + 0.5
    number = ca.floor(x)
    given = step > 0, x >= number, x - number < 1
    most = motor.rounded_by(step) * mutation(1, 0.8)
    lost = within(g.system.outputs[0].expr - told, most)
    return g.states(lost, given=given, cuts={"number": number})


@claim("world.motor.dead-zone")
def world_motor_dead_zone(mutation: Mutation) -> Statement:
    """a dead zone takes at most its width, in the torque's direction.

    What it adds to dbar.

    Given: zone > 0.
    """
    g = EffectGraph(motor.MOTOR, {"motor.dead_zone": 0.1})
    told, zone = g["tau_right"], g["motor.dead_zone"]
    lost = told - g.system.outputs[0].expr
    goals = within(lost, mutation(zone, 0.9 * zone)), lost * told >= 0
    return g.states(goals, given=zone > 0)


@claim("world.motor.line")
def line(mutation: Mutation) -> Statement:
    """on the torque-speed line a torque up to tau misses at most the smaller of tau and d(s) =
    max(tau - stall (1 - s/free), 0), s the speed in its direction, if positive.

    What a motor misses at a speed.

    Given: stall > 0, 1/free >= 0, |torque| <= tau.
    """
    t = symbols("torque speed stall slowing most", "stall slowing")
    torque, speed, stall, slowing, most = t.values()
    made = motor.on_line(torque, speed, stall, slowing)
    share = slowing * speed
    ahead, back = (motor.missing(most, stall, way * share) for way in (1, -1))
    ahead, back = ca.fmin(ahead, most), ca.fmin(back, most)
    part = mutation(1, 0.9)
    sides = part * ahead >= torque - made, part * back >= made - torque
    goals = sides, (torque - made) * torque >= 0
    given = stall > 0, slowing >= 0, within(torque, most)
    return Statement(t, goals, given)


@claim(
    "world.motor.{name}",
    over=rows(way=(1, -1), name=("thrust", "moment"), drive=("one way", "opposite ways")),
)
def pair_ahead(mutation: Mutation, way: int) -> Statement:
    """d(s) of both wheels together is largest at v1 = u1, |omega| = u2 where they drive {drive}.

    What motors add to dbar, {name}.

    Given: |v1| <= u1, l |omega| <= l u2; stall > 0, 1/free >= 0.
    """
    t = symbols("v turn u1 edge stall slowing most", "stall slowing")

    def both(v: ca.SX, turn: ca.SX) -> ca.SX:
        speeds = (v + turn, v - turn) if way > 0 else (turn + v, turn - v)
        first, second = (motor.missing(t.most, t.stall, t.slowing * s) for s in speeds)
        return first + second

    limited = positive(t.u1, t.edge), within(t.v, t.u1), within(t.turn, t.edge)
    given = t.stall > 0, t.slowing >= 0, limited
    end = both(mutation(t.u1, 0.9 * t.u1), t.edge)
    return Statement(t, end >= both(t.v, t.turn), given)


@claim(
    "world.motor.bound-{name}",
    premises="world.motor.step world.motor.dead-zone world.motor.line world.motor.{name}",
    over=rows(axis=(0, 1), name=("thrust", "moment")),
)
def motor_bound(mutation: Mutation, axis: int) -> Statement:
    """the torque that motors fail to give makes no more {name} than their bound says, for steps,
    dead zone and line at once.

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

    def short(v: ca.SX, turn: ca.SX, sides: tuple[int, int]) -> list[ca.SX]:
        return [motor.missing(most, stall, side * (v + way * turn) / r * slowing)
                for side, way in zip(sides, (1, -1), strict=True)]  # fmt: skip

    signs = "motor.dead_zone", "actuator.tau_max", "limits.v_u1[1]", "limits.v_u1[2]"
    given = [g.above_zero("robot.r", "robot.l", "motor.free", "motor.stall", "motor.step", *signs)]
    ends = (g["limits.v_u1[1]"], half * g["limits.v_u1[2]"])
    opposite = 1 if axis == 0 else -1
    for side in (1, -1):
        each = short(g["v1"], half * g["omega"], (side, side * opposite))
        whole = short(*ends, (1, opposite))
        given.append(at_least(sum(whole), sum(each)))
        for name, d, way in zip(t, each, (side, side * opposite), strict=True):
            lost = motor.rounded_by(step) + g["motor.dead_zone"] + ca.fmin(d, most)
            given.append(lost >= way * t[name])
    made = wheel_to_force(r, half, ca.vertcat(t.right, t.left))[axis]
    return g.states(within(made, bound * mutation(1, 0.9)), given=given, more=t)
