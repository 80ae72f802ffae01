"""Ground, air, sensors, and commands on their way to a base: their bounds, on their graphs."""

from dataclasses import replace

import casadi as ca

from wmr_ctrl.world import (
    command_delay,
    command_loss,
    command_quantum,
    gust,
    gyro,
    jitter,
    push,
    resistance,
    slope,
    torque_noise,
    velocity_mean,
    velocity_noise,
    wheel_commands,
)
from wmr_ctrl.world.effect import ROUNDING
from wmr_ctrl.world.model.dynamics import wheel_to_force
from wmr_proofs.claim import Claims, Mutation, rows
from wmr_proofs.methods.spec import Z3
from wmr_proofs.regions import at
from wmr_proofs.statement import (
    UNIT,
    Cuts,
    Relations,
    Statement,
    between,
    equal,
    every,
    nonnegative,
    symbols,
    within,
)

from .wheels_and_encoders import EffectGraph

HEAVIEST = {"robot.m": 1, "guard.M_max[1]": 1, "robot.g": 1}
ALONG = at(**HEAVIEST, sine=1, **{"slope.offset": 0}, along=1, across=0)
"""Straight uphill."""

claim = Claims(by=Z3())


@claim(
    "world.slope",
    by=Z3(points=(ALONG,)),
)
def world_slope(mutation: Mutation) -> Statement:
    """a slope pulls with at most m g sin(angle), and turns with at most |offset| times that.

    What a slope adds to dbar.

    Given: 0 < m <= guard.M_max, g > 0, sin(angle) >= 0; |sine|, |cosine| of the heading <= 1.
    """
    numbers = {"slope.angle": 0.1, "guard.M_max": [60.0, 20.0]}
    g = EffectGraph(slope.SLOPE, numbers, "robot guard")
    a = slope.turned(g["theta"], g["slope.direction"])
    along, across, sine = ca.cos(a), ca.sin(a), ca.sin(g["slope.angle"])
    goals = within(g.system.y, mutation(1, 0.9) * g.bound("dbar"))
    heaviest = g["guard.M_max[1]"] >= g["robot.m"]
    turns = sine >= 0, within(ca.vertcat(along, across), 1)
    given = g.above_zero("robot.m", "robot.g"), heaviest, turns
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

    Equal wheels only brake; what one has more may push. Backwards by symmetry.

    Given: {HEAVY}; {sign} >= 0; |tanh| <= 1, and as {sign} >= 0 has it tanh((v1 + l omega)/v_s)
    {pair} tanh((v1 - l omega)/v_s) >= 0.
    """
    numbers = {"resistance.rolling": [0.01, 0.02], "guard.M_max": [60.0, 20.0]}
    g = EffectGraph(resistance.RESISTANCE, numbers, "robot guard")
    v, omega, half = g["v1"], g["omega"], g["robot.l"]
    right, left = resistance.smoothed(v, half * omega, g["robot.v_s"])
    load = resistance.load_of_wheel(g["robot.m"], g["robot.g"])
    rolling = (g["resistance.rolling[1]"], g["resistance.rolling[2]"])
    more = g.bound("dbar")[axis]
    heaviest = g["guard.M_max[1]"] >= g["robot.m"]
    moves = right + left if axis == 0 else right - left
    signs = nonnegative(*rolling, g[f"resistance.viscous[{axis + 1}]"], load, moves)
    sizes = g.above_zero("robot.l", "robot.g", "robot.m"), heaviest
    turns = (v, omega)[axis] >= 0, within(ca.vertcat(right, left), 1)
    given = signs, sizes, turns
    goal = more * mutation(1, 0.9) >= g.system.y[axis]
    return g.states(goal, given=given, cuts={"right": right, "left": left})


@claim(
    "world.noise.{name}",
    over=rows(axis=(0, 1), name=("thrust", "moment"), most=("2 n std/r", "2 l n std/r")),
)
def noise_thrust(mutation: Mutation, axis: int) -> Statement:
    """torque noise within n std on each wheel makes a {name} of at most {most}.

    What torque noise adds to dbar.

    Given: r, l > 0, std >= 0; |each normal number| <= n.
    """
    numbers = {"disturbance.truncate": 5.0}
    g = EffectGraph(torque_noise.TORQUE_NOISE_EFFECT, numbers, "robot")
    believed, most = (g["robot.r"], g["robot.l"]), g["disturbance.truncate"]
    bound = g.bound("dbar")[axis]
    force = wheel_to_force(*believed, g.system.y)[axis]
    drawn = within(g.column("torque"), most)
    given = g.above_zero("robot.r", "robot.l"), g["disturbance.std"] >= 0, drawn
    return g.states(within(force, bound * mutation(1, 0.9)), given=given)


@claim(
    "world.gust",
)
def world_gust(mutation: Mutation) -> Statement:
    """a filter's share of the size stays within [-1, 1], and the force within the size.

    What gusts add to dbar.

    Given: shares before and numbers within [-1, 1], size >= 0, 0 <= keep = exp(-T/time) <= 1.
    """
    g = EffectGraph(gust.GUST, {"gust.size": [1.0, 1.0]})
    keep = ca.exp(-g["clock.control"] / g["gust.time"])
    size, part = g.bound("dbar"), mutation(1, 0.9)
    drawn = ca.vertcat(g.column(gust.SHARE.name), g.column(gust.NUMBERS.name))
    pairs = zip(*map(ca.vertsplit, (g.system.update, g.system.y, part * size)), strict=True)
    goals = [(within(x, part), within(y, most)) for x, y, most in pairs]
    sides = between(0, keep, 1), nonnegative(size[0], size[1])
    return g.states(goals, given=(within(drawn, 1), sides), cuts={"keep": keep})


@claim("world.gyro")
def world_gyro(mutation: Mutation) -> Statement:
    """a gyro is off by at most |bias| + noise.

    What it adds to nbar.

    Given: noise >= 0; the random number within [-1, 1].
    """
    g = EffectGraph(gyro.GYRO, {"gyro.enabled": True})
    most = g.bound("nbar")[1] * mutation(1, 0.9)
    given = g["gyro.noise"] >= 0, within(g[f"{gyro.NUMBERS.name}[1]"], 1)
    return g.states(within(g.system.y[0] - g["omega"], most), given=given)


@claim("world.velocity-noise")
def world_velocity_noise(mutation: Mutation) -> Statement:
    """noise of the velocity is at most its half-width, per axis.

    What it adds to nbar.

    Given: half-widths >= 0; random numbers within [-1, 1].
    """
    g = EffectGraph(velocity_noise.VELOCITY_NOISE, {})
    half = g.bound("nbar")
    goals = within(g.system.y - g.system.u, mutation(1, 0.9) * half)
    drawn = within(g.column(velocity_noise.NUMBERS.name), 1)
    return g.states(goals, given=(drawn, nonnegative(*ca.vertsplit(half))))


AGES = {"sensor.velocity_window": 0.02, "sensor.velocity_age": 0.01, "clock.control": 0.01}


@claim(
    "world.velocity-mean.bound",
)
def world_velocity_mean(mutation: Mutation) -> Statement:
    """the mean velocity times the window in its bound is the distance from that window's start to
    its end, and both are as old as the bound says, in periods since each distance was read.

    What the guard counts as age and window.

    Given: T > 0; a window of two periods that ended one period ago, after the first sample.
    """
    g = EffectGraph(velocity_mean.VELOCITY_MEAN, AGES, "clock limits")
    T, name = g["clock.control"], velocity_mean.PLACE.name
    seen = [g.column(f"{name}_{k}") for k in (1, 2, 3)]
    goals: list[Relations] = [every(g.system.update, ca.vertcat(g["path"], g["theta"], *seen[:2]))]
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
    """the mean {what} as computed is off that of the exact way by no more than the error that its
    bound tells.

    What a mean adds to nbar: the rounding of ways.

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
    off = within(t.shown * window - t.way, most * window)
    whole = g.states(off, given=given, more=t)
    return replace(whole, computed={"shown": g.system.y[axis]})


@claim("world.push")
def world_push(mutation: Mutation) -> Statement:
    """an adversary's push is at most its size, per axis.

    What it adds to dbar.

    Given: r, l > 0, size >= 0; at every velocity.
    """
    g = EffectGraph(push.PUSH, {"disturbance.push": [1.0, 1.0]})
    size = g.bound("dbar")
    force = wheel_to_force(g["robot.r"], g["robot.l"], g.system.y)
    sides = g.above_zero("robot.r", "robot.l"), nonnegative(size[0], size[1])
    return g.states(within(force, mutation(1, 0.9) * size), given=sides)


command_claim = Claims(by=Z3())


@command_claim("world.command-delay.bound")
def command_delay_bound(mutation: Mutation) -> Statement:
    """the bound of a command's delay is what its own graph holds a command back by, which it leaves
    as it is.

    What the governor counts as the delay of a command.

    Given: any delay.
    """
    g = EffectGraph(command_delay.COMMAND_DELAY, {"base.delay": 0.02})
    assert g.system.transport is not None
    late = g.bound("delay")[0] == mutation * g.system.transport
    return g.states(late, every(g.system.y, g.system.u))


@command_claim(
    "world.command-loss.bound",
)
def command_loss_bound(mutation: Mutation) -> Statement:
    """no more commands in a row are missed than the bound tells, silence lasts for the periods that
    were missed and no longer, and the base never stops in between.

    What the governor counts as lost commands.

    Given: losses >= 0 whole, timeout at least (losses + 1) T less 1e-9 of it, which is at most h; T
    a multiple of h > 0; so far no more were missed in a row than the bound tells, and silence lasts
    for the periods that were missed.
    """
    numbers = {"base.losses": 2, "base.timeout": 0.05, "clock.control": 0.01}
    g = EffectGraph(command_loss.COMMAND_LOSS, numbers, "clock")
    t = symbols("steps phase before")
    h, T, most = g["clock.plant"], g["clock.control"], g.bound("losses")[0]
    steps = jitter.whole(T / h)
    since = g["step"] - jitter.whole(g["base.delay"] / h)
    cuts = {"steps": steps, "phase": since - steps * ca.floor(since / steps)}
    longest = (g["base.losses"] + 1) * T
    missed, silent = g[command_loss.MISSED.name], g[command_loss.SILENT.name]
    given = (
        h > 0, equal(T, t.steps * h), g["base.losses"] >= 0, t.steps >= 1,
        g["base.timeout"] >= longest * (1 - ROUNDING), h >= longest * ROUNDING,
        between(0, missed, most), nonnegative((most - missed) * (most - missed - 1), t.before),
        t.steps >= t.before + 1, silent >= 0,
        t.phase == ca.if_else(t.before + 1 >= t.steps, 0, t.before + 1),
        (t.steps - t.before - 1) * (t.steps - t.before - 2) >= 0,
        missed * t.steps + t.before >= silent,
    )  # fmt: skip
    now, silence, missing = ca.vertsplit(g.system.update, [0, 2, 3, 4])
    few = mutation(1, 0.9) * most >= missing
    goals = few, missing * t.steps + t.phase >= silence, every(g.system.y, now)
    return g.states(goals, given=given, cuts=cuts, more=t)


@command_claim("world.command-quantum.bound")
def command_quantum_bound(mutation: Mutation) -> Statement:
    """a rounded command is off by at most half a step, per axis.

    What the governor counts as the error of a command.

    Given: step > 0; whole parts of two numbers: n <= x < n + 1.
    """
    g = EffectGraph(command_quantum.COMMAND_QUANTUM, {"base.quantum": [0.01, 0.01]})
    off, most, given = g.system.y - g.system.u, g.bound("command"), list[Relations]()
    cuts = Cuts()
    for i in (0, 1):
        step = g[f"base.quantum[{i + 1}]"]
        x = g.system.u[i] / ca.if_else(step > 0, step, 1) + 0.5
        cuts[f"number{i + 1}"] = number = ca.floor(x)
        given += [step > 0, x >= number, x - number < 1]
    return g.states(within(off, mutation(1, 0.9) * most), given=given, cuts=cuts)


@command_claim("world.wheel-commands")
def wheels_heard(mutation: Mutation) -> Statement:
    """behind dead bands of the wheels the command that acts is off by at most command + dropped of
    the bound, and no larger than the one that arrived by more than command, per axis.

    What a filter counts as the error of a command, and what a clip does.

    Given: l > 0, size >= 0; no ramps.
    """
    g = EffectGraph(wheel_commands.WHEEL_COMMANDS, {"base.wheel_deadband": 0.03}, "robot")
    error, dropped = mutation(1, 0.9) * g.bound("command"), g.bound("dropped")
    u, acts = g.system.u, g.system.y
    goals = within(acts - u, error + dropped), within(acts, abs(u) + error)
    return g.states(goals, given=(g.above_zero("robot.l"), g["base.wheel_deadband"] >= 0))
