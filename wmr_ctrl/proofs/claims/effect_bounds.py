"""Motors, ground and air: what they add to the guard's assumptions, on their graphs."""

from __future__ import annotations

from fractions import Fraction

import casadi as ca

from wmr_ctrl.control.applied import followed
from wmr_ctrl.guard.delay import integral, moved
from wmr_ctrl.model.dynamics import wheel_to_force
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.world import EffectGraph, positive
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Statement, above, at_least, equal, symbols, within
from wmr_ctrl.world import (
    gust,
    gyro,
    lag,
    motor,
    push,
    resistance,
    slope,
    torque_noise,
    velocity_noise,
)

ALONG = {
    name: Fraction(value)
    for name, value in {
        "robot.m": 1, "robot.g": 1, "sine": 1, "slope.offset": 0, "along": 1, "across": 0
    }.items()
}  # fmt: skip
"""Straight uphill."""
HEAVY = "coefficients >= 0, 0 < m <= guard.M_max; l, g > 0"


claim = Claims(by=Z3(effort=150))


@claim(
    "world.lag.stepped",
    given="e = exp(-h/tau_min); tau_min <= tau <= b, exponentials as symbols with exp(-h/a) <= "
    "exp(-h/tau_min) <= exp(-h/tau) <= exp(-h/b) < 1 and h <= b (exp(h/b) - 1)",
)
def held(mutation: Mutation) -> Statement:
    """a lag that holds a plant step's last value adds h Z1 + s Z1 <= what Z adds that rises with a
    = h e/(1 - e) and falls with b, and ends no higher, for every s in [a, b].

    What a lag in plant steps counts for: that of a slightly smaller time constant.
    """
    # One plant step of the lag that holds its value, and Z that the guard follows.
    t = symbols("z p step share growth b between least falls rises")
    z, p, h, s, growth, b, e, least, falls, rises = t.values()
    a, after = lag.equivalent_lag(h, growth), lag.followed(p, e, z)
    guarded = integral(z, p, (h, b * (1 - falls), a * (1 - rises)))
    goals = (
        at_least(guarded + s * moved(z, p, (falls, rises)), (mutation(1, 1.01) * h + s) * after),
        at_least(moved(z, p, (falls, rises)), after),
    )
    given = (
        at_least(z), at_least(p), above(h), above(growth), at_least(s, a), at_least(b, s),
        equal(least * (1 + growth), 1), at_least(rises), at_least(least, rises),
        at_least(e, least), at_least(falls, e), above(1, falls),
        at_least(b * (1 - falls), h * falls),
    )  # fmt: skip
    return Statement(t, goals, given)


@claim(
    "world.lag.applied",
    given="0 < e < 1 for e = exp(-h/lag); four plant steps in a period, delay of one period "
    "and three steps",
)
def applied(mutation: Mutation) -> Statement:
    """the torque that laws are told was applied is the mean of what acted in the plant steps of the
    sample behind delay and lag, and what acts at its end is the drives' own.

    The observer and the monitor reckon with what the simulated drives did.
    """
    t, steps, part = symbols("newest older oldest acting e"), 4, 3
    newest, older, oldest, acting, e = t.values()
    told = followed([newest, older, oldest], (1, part, steps), acting, e)
    total = ca.SX(0)
    for step in range(steps):
        acting = lag.followed(oldest if step < part else older, e, acting)
        total = total + acting
    goals = (equal(told[0], mutation * total / steps), equal(told[1], acting))
    return Statement(t, goals, (above(e), above(1, e)))


@claim("world.motor.step", given="step > 0")
def stepped(mutation: Mutation) -> Statement:
    """torque in steps is off by at most half a step.

    What a motor's resolution adds to dbar.
    """
    g = EffectGraph(motor.MOTOR, (("motor.step", 0.1),))
    told, step = g["tau_right"], g["motor.step"]
    x = told / step + 0.5
    number = ca.floor(x)
    given = (above(step), at_least(x, number), above(1, x - number))
    most = motor.rounded_by(step) * mutation(1, 0.8)
    return g.states(within(g.system.outputs[0].expr - told, most), given, {"number": number})


@claim("world.motor.dead-zone", given="zone > 0")
def world_motor_dead_zone(mutation: Mutation) -> Statement:
    """a dead zone takes at most its width, in the torque's direction.

    What it adds to dbar.
    """
    g = EffectGraph(motor.MOTOR, (("motor.dead_zone", 0.1),))
    told, zone = g["tau_right"], g["motor.dead_zone"]
    lost = told - g.system.outputs[0].expr
    goals = (*within(lost, mutation(zone, 0.9 * zone)), at_least(lost * told))
    return g.states(goals, (above(zone),))


@claim("world.motor.line", given="stall > 0, 1/free >= 0, |torque| <= tau")
def line(mutation: Mutation) -> Statement:
    """on the torque-speed line a torque up to tau misses at most the smaller of tau and d(s) =
    max(tau - stall (1 - s/free), 0), s the speed in its direction, if positive.

    What a motor misses at a speed.
    """
    t = symbols("torque speed stall slowing most", "stall slowing")
    made = motor.on_line(t["torque"], t["speed"], t["stall"], t["slowing"])
    share = t["slowing"] * t["speed"]
    ahead, back = (motor.missing(t["most"], t["stall"], way * share) for way in (1, -1))
    ahead, back = ca.fmin(ahead, t["most"]), ca.fmin(back, t["most"])
    part = mutation(1, 0.9)
    goals = (
        at_least(part * ahead, t["torque"] - made),
        at_least(part * back, made - t["torque"]),
        at_least((t["torque"] - made) * t["torque"]),
    )
    given = (above(t["stall"]), at_least(t["slowing"]), *within(t["torque"], t["most"]))
    return Statement(t, goals, given)


@claim.also(
    "world.motor.moment",
    "and there too where they drive opposite ways",
    "What motors add to dbar, moment.",
    way=-1,
)
@claim("world.motor.thrust", given="|v1| <= u1, l |omega| <= l u2; stall > 0, 1/free >= 0")
def pair_ahead(mutation: Mutation, way: int = 1) -> Statement:
    """d(s) of both wheels together is largest at v1 = u1, |omega| = u2 where they drive one way.

    What motors add to dbar, thrust.
    """
    t = symbols("v turn u1 edge stall slowing most", "stall slowing")

    def both(v: ca.SX, turn: ca.SX) -> ca.SX:
        speeds = (v + turn, v - turn) if way > 0 else (turn + v, turn - v)
        first, second = (motor.missing(t["most"], t["stall"], t["slowing"] * s) for s in speeds)
        return first + second

    given = (
        above(t["stall"]), at_least(t["slowing"]), above(t["u1"]), above(t["edge"]),
        *within(t["v"], t["u1"]), *within(t["turn"], t["edge"]),
    )  # fmt: skip
    end = both(mutation(t["u1"], 0.9 * t["u1"]), t["edge"])
    return Statement(t, (at_least(end, both(t["v"], t["turn"])),), given)


@claim(
    "world.slope",
    given="m, g > 0, sin(angle) >= 0; |sine|, |cosine| of the heading <= 1",
    by=Z3(effort=150, points=(ALONG,)),
)
def world_slope(mutation: Mutation) -> Statement:
    """a slope pulls with at most m g sin(angle), and turns with at most |offset| times that.

    What a slope adds to dbar.
    """
    g = EffectGraph(slope.SLOPE, (("slope.angle", 0.1),))
    a = slope.turned(g["theta"], g["slope.direction"])
    along, across, sine = ca.cos(a), ca.sin(a), ca.sin(g["slope.angle"])
    pull = slope.downhill(g["robot.m"], g["robot.g"], sine)
    bounds = slope.pulled_at_most(pull, g["slope.offset"])
    goals = [part for i in (0, 1) for part in within(g.system.y[i], mutation(1, 0.9) * bounds[i])]
    shares = (*within(along, 1), *within(across, 1))
    given = (*positive(g, "robot.m", "robot.g"), at_least(sine), *shares)
    return g.states(goals, given, {"along": along, "across": across, "sine": sine})


@claim.also(
    "world.resistance.moment",
    "and turns it on with at most l times that",
    "The same for the turn.",
    given=f"{HEAVY}; omega >= 0; |tanh| <= 1, their difference >= 0 as omega >= 0 has it",
    axis=1,
)
@claim(
    "world.resistance.thrust",
    given=f"{HEAVY}; v1 >= 0; |tanh| <= 1, and as v1 >= 0 has it tanh((v1 + l omega)/v_s) + "
    "tanh((v1 - l omega)/v_s) >= 0",
)
def resisted_thrust(mutation: Mutation, axis: int = 0) -> Statement:
    """rolling resistance drives the robot on with at most the difference of the wheels'.

    Equal wheels only brake; what one has more may push. Backwards by symmetry.
    """
    numbers = (("resistance.rolling", [0.01, 0.02]), ("guard.M_max", [60.0, 20.0]))
    g = EffectGraph(resistance.RESISTANCE, numbers, "robot guard")
    v, omega, half = g["v1"], g["omega"], g["robot.l"]
    right, left = resistance.smoothed(v, half * omega, g["robot.v_s"])
    load = resistance.load_of_wheel(g["robot.m"], g["robot.g"])
    rolling = (g["resistance.rolling[1]"], g["resistance.rolling[2]"])
    more = g.bound("dbar")[axis]
    heaviest = at_least(g["guard.M_max[1]"], g["robot.m"])
    moves = right + left if axis == 0 else right - left
    given = (
        *(at_least(item) for item in (*rolling, g[f"resistance.viscous[{axis + 1}]"], load, moves)),
        *positive(g, "robot.l", "robot.g", "robot.m"), heaviest,
        at_least(v if axis == 0 else omega), *within(right, 1), *within(left, 1),
    )  # fmt: skip
    goal = at_least(more * mutation(1, 0.9), g.system.y[axis])
    return g.states((goal,), given, {"right": right, "left": left})


@claim.also(
    "world.noise.moment", "and a moment of at most l times that", "The same for the moment.", axis=1
)
@claim("world.noise.thrust", given="r, l > 0, std >= 0; |each normal number| <= n")
def noise_thrust(mutation: Mutation, axis: int = 0) -> Statement:
    """torque noise within n std on each wheel makes a thrust of at most 2 n std/r.

    What torque noise adds to dbar.
    """
    numbers = (("disturbance.truncate", 5.0),)
    g = EffectGraph(torque_noise.TORQUE_NOISE_EFFECT, numbers, "robot")
    believed, most = (g["robot.r"], g["robot.l"]), g["disturbance.truncate"]
    bound = g.bound("dbar")[axis]
    force = wheel_to_force(*believed, g.system.y)[axis]
    drawn = [part for i in (1, 2) for part in within(g[f"torque[{i}]"], most)]
    given = (*positive(g, "robot.r", "robot.l"), at_least(g["disturbance.std"]), *drawn)
    return g.states(within(force, bound * mutation(1, 0.9)), given)


@claim(
    "world.gust",
    given="shares before and numbers within [-1, 1], size >= 0, 0 <= keep = exp(-T/time) <= 1",
)
def world_gust(mutation: Mutation) -> Statement:
    """a filter's share of the size stays within [-1, 1], and the force within the size.

    What gusts add to dbar.
    """
    g = EffectGraph(gust.GUST, (("gust.size", [1.0, 1.0]),))
    keep = ca.exp(-g["clock.control"] / g["gust.time"])
    before = [g[f"{gust.SHARE.name}[{i}]"] for i in (1, 2)]
    numbers = [g[f"{gust.NUMBERS.name}[{i}]"] for i in (1, 2)]
    size = g.bound("dbar")
    part = mutation(1, 0.9)
    goals = [
        item
        for i in (0, 1)
        for item in (*within(g.system.update[i], part), *within(g.system.y[i], part * size[i]))
    ]
    given = [item for value in (*before, *numbers) for item in within(value, 1)]
    sides = (at_least(keep), at_least(1, keep), *(at_least(item) for item in size))
    return g.states(goals, (*given, *sides), {"keep": keep})


@claim("world.gyro", given="noise >= 0; the random number within [-1, 1]")
def world_gyro(mutation: Mutation) -> Statement:
    """a gyro is off by at most |bias| + noise.

    What it adds to nbar.
    """
    g = EffectGraph(gyro.GYRO, (("gyro.enabled", True),))
    most = g.bound("nbar")[1] * mutation(1, 0.9)
    given = (at_least(g["gyro.noise"]), *within(g[f"{gyro.NUMBERS.name}[1]"], 1))
    return g.states(within(g.system.y[0] - g["omega"], most), given)


@claim("world.velocity-noise", given="half-widths >= 0; random numbers within [-1, 1]")
def world_velocity_noise(mutation: Mutation) -> Statement:
    """noise of the velocity is at most its half-width, per axis.

    What it adds to nbar.
    """
    g = EffectGraph(velocity_noise.VELOCITY_NOISE, ())
    half = g.bound("nbar")
    numbers = [g[f"{velocity_noise.NUMBERS.name}[{i}]"] for i in (1, 2)]
    off = g.system.y - g.system.u
    goals = [item for i in (0, 1) for item in within(off[i], mutation(1, 0.9) * half[i])]
    given = [item for value in numbers for item in within(value, 1)]
    return g.states(goals, (*given, *(at_least(item) for item in half)))


@claim("world.push", given="r, l > 0, size >= 0; at every velocity")
def world_push(mutation: Mutation) -> Statement:
    """an adversary's push is at most its size, per axis.

    What it adds to dbar.
    """
    g = EffectGraph(push.PUSH, (("disturbance.push", [1.0, 1.0]),))
    size = g.bound("dbar")
    force = wheel_to_force(g["robot.r"], g["robot.l"], g.system.y)
    goals = [item for i in (0, 1) for item in within(force[i], mutation(1, 0.9) * size[i])]
    sides = (*positive(g, "robot.r", "robot.l"), *(at_least(item) for item in size))
    return g.states(goals, sides)
