"""Assumptions of the certified corridor about laws, guard and wheels off their limits, and about
commands: late ones, and those to bases that take velocities.

Under the conditions that are checked for a scenario, the graph is what `wmr_ctrl.theory.corridor`
reads.
"""

from dataclasses import replace

from casadi import SX, cos, fmax, horzcat, if_else, logic_and, sin, vertcat, vertsplit

from wmr_ctrl.control.barrier.stable import smooth_barrier, stable_barrier
from wmr_ctrl.control.filter.channels import WAYS, scaled
from wmr_ctrl.control.guard.delay import InFlight, in_flight, largest_force
from wmr_ctrl.control.guard.guard import MAPS, Bounds, clipped, guarded
from wmr_ctrl.control.laws.prox import carried_plainly, mixture
from wmr_ctrl.control.laws.velocity_loop import cut
from wmr_ctrl.world import command_dead_band, command_ramp, jitter, speed_loops, wheel_speed_limit
from wmr_ctrl.world.model.dynamics import force_to_wheel, full_thrust
from wmr_ctrl.world.pose_sensor import reckoned
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import (
    Group,
    Statement,
    between,
    every,
    nonnegative,
    positive,
    symbols,
    when,
)

from .common import EITHER_BARRIER
from .effect_bounds import EffectGraph, Jittering
from .filter_rounding import Limited
from .guard_axis import NUMBERS
from .prox import Step

claim = Claims()


@claim("corridor.prox", premises="transport.plain prox.linear", each=EITHER_BARRIER)
def prox(mutation: Mutation, smooth: bool) -> Statement:
    """|E v* + (1-E) c+| <= v_u2 implies that this is the law's v+, as its corridor assumes;
    with either barrier.

    Away from the limits the step is a weighted mean of the transported velocity and the target.

    Given: 0 < v_u2 < v_u1, v_u2 < 1e100, 0 < E < 1; v* = v + c_m - c.
    """
    s = Step(smooth)
    t, carried = s.inputs, s.free.carried
    plainly = carried_plainly(t.v, t.c, t.followed)
    after = mixture(plainly, t.target, s.shares)
    given = carried == plainly, t.u2 < 1e100, [t.u2 >= way * after for way in (1, -1)]
    return s.states((s.end == mutation(after, after + carried),), given, ("carried",))


@claim("corridor.mb", each=EITHER_BARRIER)
def mb(mutation: Mutation, smooth: bool) -> Statement:
    """|v|, |v_c0| <= v_u2 imply that V1/A = (v - v_c0)/2 and q = 1; with either barrier.

    Away from the limits the barrier adds nothing to the model-based law.

    Given: 0 < v_u2 < v_u1, v_u2 < 1e100.
    """
    t = symbols("v c u1 u2", "u1 u2")
    v, c, u1, u2 = t.values()
    barrier = (smooth_barrier if smooth else stable_barrier)(c, v, u1, u2)
    given = u2 > 0, u1 > u2, u2 < 1e100, [mutation(1, 2) * u2 >= abs(item) for item in (v, c)]
    goals = 2 * barrier.V1_over_A == v - c, barrier.q == 1
    return Statement(t, goals, given)


@claim("corridor.kanayama")
def kanayama(mutation: Mutation) -> Statement:
    """|value| <= limit on both axes implies that the clip leaves the value as it is.

    Within its limits the command is not clipped.

    Given: every limit >= 0.
    """
    t = symbols("a b A B", "A B")
    values, most = vertcat(t.a, t.b), vertcat(t.A, t.B)
    inside = [mutation(1, 2) * most[i] >= abs(values[i]) for i in (0, 1)]
    return Statement(t, every(cut(values, most), values), (nonnegative(t.A, t.B), inside))


@claim("corridor.guard")
def guard(mutation: Mutation) -> Statement:
    """With S = M_min alpha: |F + S y|, |S y| <= S (u1 - nbar) - net, |F| <= S (u1 - f_speed) - net
    imply that the guard leaves F as it is, and that its safe point is 0.

    Under these conditions the law drives as if there were no guard.

    Given: no late command; M_min, M_max, T, alpha, u1 > 0, nbar, f_speed, brake >= 0, dbar >=
    f_min.
    """
    t = symbols(f"{NUMBERS} y force", NUMBERS)
    bounds = Bounds(**{name: t[name] for name in NUMBERS.split()})
    slope, net = t.M_min * t.alpha, bounds.net
    near, far = (slope * (t.u1 - t[name]) - net for name in ("nbar", "f_speed"))
    sizes = (t.force + slope * t.y, near), (slope * t.y, near), (t.force, far)
    held = guarded(vertcat(t.force, 0), vertcat(t.y, 0), bounds)
    free = [most >= mutation(1, 0.5) * abs(size) for size, most in sizes]
    signs = positive(t.M_min, t.M_max, t.alpha, t.period, t.u1), nonnegative(t.nbar, t.f_speed)
    given = signs, nonnegative(t.brake, net), free
    return Statement(t, (held.force[0] == t.force, held.safe[0] == 0), given)


@claim(
    "corridor.wheels",
    each={"linear-first": {"key": "linear-first"}, "rotation-first": {"key": "rotation-first"}},
)
def wheels(mutation: Mutation, key: str) -> Statement:
    """Torques within tau_max on both wheels imply that either map leaves the force as it is.

    Under this condition the wheels' limit does not act.

    Given: r, l, tau_max > 0; the guard's safe point is 0, as it is without a guard.
    """
    t = symbols("force moment r half tau", "r half tau")
    force = vertcat(t.force, t.moment)
    torque = force_to_wheel(t.r, t.half, force)
    mapped = MAPS[key](force, full_thrust(t.r, t.tau), t.half, SX.zeros(2))
    weak = [mutation(1, 2) * t.tau >= abs(torque[i]) for i in (0, 1)]
    return Statement(t, every(mapped, force), (positive(t.r, t.half, t.tau), weak))


@claim("corridor.product")
def product(mutation: Mutation) -> Statement:
    """|a + ratio b| <= P and |a - ratio b| <= Q imply 4 ratio |a b| <= max(P^2, Q^2).

    The largest product of two errors follows from the largest sums of them.

    Given: ratio > 0.
    """
    t = symbols("a b P Q ratio", "P Q ratio")
    a, b, P, Q, ratio = t.values()
    sums = (a + ratio * b, a - ratio * b)
    given = ratio > 0, abs(sums[0]) <= P, abs(sums[1]) <= Q
    size = mutation(4, 5) * ratio * abs(a * b)
    return Statement(t, fmax(P * P, Q * Q) >= size, given)


SCALES = {
    f"{on}-{scale}{' by direction' * (told > 1)}": {"on": on, "scale": scale, "told": told}
    for told in (1, 2)
    for on, scales in (("both", ""), ("wheels", ""), ("body", "axes"))
    for scale in ("curvature", "turn", "drive", *scales.split())
}
"""How a filter brings a command within its limits, the speeds that it limits, and limits of each.
"""


@claim("corridor.filter", each=SCALES)
def passes(mutation: Mutation, on: str, scale: str, told: int) -> Statement:
    """A command whose limited speeds are all within their limits, also those of its first axis
    alone if one axis goes first, is sent unchanged.  This holds if the filter limits v and omega,
    the wheels, or all of these; for one factor, turning first or driving first; and for a factor of
    each axis if it limits v and omega alone.

    Under this condition the base receives the law's command. The first axis alone matters only if
    wheels have other limits backwards than forwards.

    Given: l > 0; limits lo < 0 < hi of each speed, lo <= 0 <= hi where both directions have limits
    of their own.
    """
    a = Limited(on, told)
    asked, *_ = a.asked
    first = {"turn": [SX(0), asked[1]], "drive": [asked[0], SX(0)]}.get(scale, asked)
    inside = [a.kept(command, mutation(0, 1), axes) for command in (asked, first)
              for axes in (True, False)]  # fmt: skip
    goals = every(scaled(*a.asked, scale), vertcat(*asked))
    return Statement(a, goals, (a.stated, inside))


@claim("corridor.dead-band")
def dead_band(mutation: Mutation) -> Statement:
    """each axis' command behind its dead band has an error of at most the band's size, and none if
    the command is larger.

    The effect of a dead band is treated as an error of the command.

    Given: any size >= 0.
    """
    g = EffectGraph(command_dead_band.COMMAND_DEAD_BAND, {"base.deadband": [0.01, 0.01]})
    goals, most = Group(), g.bound("dropped")
    for i in (0, 1):
        off = g.system.y[i] - g.system.u[i]
        goals.append(mutation(1, 0.9) * abs(most[i]) >= abs(off))
        goals.append(if_else(abs(g.system.u[i]) > g[f"base.deadband[{i + 1}]"], abs(off), 0) <= 0)
    return g.states(goals, given=nonnegative(*vertsplit(g.column("base.deadband"))))


@claim("corridor.wheel-speed")
def wheel_speed(mutation: Mutation) -> Statement:
    """|v + l omega|, |v - l omega| <= r w_max imply that the firmware leaves the command as it is.

    Under this condition no wheel's speed is clipped.

    Given: r, l, w_max > 0.
    """
    g = EffectGraph(wheel_speed_limit.WHEEL_SPEED_LIMIT, {"base.w_max": 10.0})
    r, l, most = g["robot.r"], g["robot.l"], g["base.w_max"]
    speeds = (abs(g.system.u[0] + way * l * g.system.u[1]) for way in WAYS)
    given = positive(r, l, most), [mutation(1, 2) * r * most >= speed for speed in speeds]
    return g.states(every(g.system.y, g.system.u), given=given)


@claim("corridor.pi-loop")
def pi_loop(mutation: Mutation) -> Statement:
    """the PI loop with anti-windup equals the one without.

    If no torque limit acts, the certificate may treat the loop as linear.

    Given: r, l, tau_max > 0; no wheel is at its torque limit.
    """
    loops = ({"base.loop": "pi", "base.antiwindup": resting} for resting in (True, False))
    g, plain = (EffectGraph(speed_loops.SPEED_LOOP, numbers) for numbers in loops)
    own = g.system
    graph = plain.system.function("plain", [plain.system.update, plain.system.y])
    following, torque = graph(own.u, own.x, own.p)
    most = g["actuator.tau_max"]
    weak = [mutation(1, 2) * most > abs(torque[i]) for i in (0, 1)]
    given = g.above_zero("robot.r", "robot.l", "actuator.tau_max"), weak
    return g.states(every(own.update, following), every(own.y, torque), given=given)


@claim("corridor.guard-late", each={"constant": {"jitters": False}, "jitter": {"jitters": True}})
def late_guard(mutation: Mutation, jitters: bool) -> Statement:
    """F + S (w + ahead + a) <= S u1 - net and c F + S (w + ahead) <= S u1 - c net for w = y + nbar
    and for w = f_speed, the same with 0 for F, all of it backwards too, and |F| at most the largest
    force, imply that the guard leaves F as it is, and that 0 is safe; behind a constant delay and
    with jitter.

    Under these conditions the law drives as if there were no guard, although commands are late.

    Given: M_min, M_max, T, alpha, u1, delay > 0, S = M_min alpha, net >= 0; ahead, back, and what
    the last command adds to them until the new one is sure to act: a >= 0, 0 without jitter; c = 1
    + alpha J >= 1.
    """
    t = symbols(f"{NUMBERS} y force J delay mixed ahead back a_ahead a_back slope stretch braking "
                "largest", f"{NUMBERS} J delay mixed slope stretch braking largest")  # fmt: skip
    b = Bounds(**{name: t[name] for name in NUMBERS.split()}, delay=t.delay)
    coming = InFlight(t.ahead, t.back)
    if jitters:
        b = replace(b, jitter=t.J, mixed=t.mixed)
        coming = replace(coming, again=InFlight(t.a_ahead, t.a_back))
    S, c = t.slope, t.stretch if jitters else SX(1)
    cuts = {"slope": b.M_min * b.alpha, "braking": b.braking, "largest": largest_force(b)}
    if jitters:
        cuts["stretch"] = 1 + b.alpha * t.J
    sizes = Group()
    for way, side in ((1, "ahead"), (-1, "back")):
        for w in (way * t.y + t.nbar, t.f_speed):
            for F in (way * t.force, SX(0)):
                room = S * (t.u1 - w - t[side])
                again = t[f"a_{side}"] if jitters else SX(0)
                sizes.append(room - S * again >= F + b.net)
                if jitters:
                    sizes.append(room >= c * mutation(1, 0.5) * (F + b.net))
    if not jitters:
        sizes[0] = mutation(1, 2) * S * (t.u1 - t.y - t.nbar - t.ahead) >= t.force + b.net
    given = (
        positive(t.M_min, t.M_max, t.alpha, t.period, t.u1, t.delay, S),
        [c >= 1] * jitters, nonnegative(b.net, t.a_ahead, t.a_back),
        t.largest >= abs(t.force), sizes,
    )  # fmt: skip
    goals = tuple(clipped(asked, t.y, b, coming) == asked for asked in (t.force, SX(0)))
    return Statement(t, goals, given, cuts)


@claim("corridor.guard-sums")
def late_sums(mutation: Mutation) -> Statement:
    """two commands that may act for tau_j add at most sum tau_j (F_j + N)/M_min ahead and sum tau_j
    (N - F_j)/M_min back; in a piece in which either may act, one of the two bounds holds.

    So the guard's bound is linear in the commands, and an output of the loop.

    Given: M_min, T > 0, tau_j >= 0; |F_j| <= N, N >= net.
    """
    t = symbols(f"{NUMBERS} F1 F2 N t1 t2", f"{NUMBERS} t1 t2")
    b = Bounds(**{name: t[name] for name in NUMBERS.split()})
    first, second = (vertcat(t[name], 0) for name in ("F1", "F2"))
    sums = in_flight([(first, t.t1), (horzcat(second, first), t.t2)], 0, b)
    scale, size = t.period / t.M_min, mutation(1, 0.5) * t.N
    goals = Group()
    for way, side in ((1, sums.ahead), (-1, sums.back)):
        most = t.t1 * (way * t.F1 + size) + t.t2 * (fmax(way * t.F1, way * t.F2) + size)
        goals.append(scale * most >= side)
    largest = b.net <= t.N, abs(t.F1) <= t.N, abs(t.F2) <= t.N
    given = positive(t.M_min, t.period), nonnegative(t.t1, t.t2), largest
    return Statement(t, goals, given)


@claim("corridor.jitter")
def overtaken(mutation: Mutation) -> Statement:
    """the acting command is the last one that arrived or the one before it, and the hypotheses hold
    again in the next plant step.

    Drives with jitter let one of the last two commands act, never an older one.

    Given: jitter a multiple of h, h > 0; each drawn time is within the jitter; the last command
    that arrived is waiting or, from its drawn time on, acting; before that the previous command
    acts.
    """
    g = Jittering()
    h, t = g["clock.plant"], g.free | symbols("older")
    now, waiting, wait = (part[0] for part in vertsplit(g.system.update, [0, 2, 4, 5]))
    acting, last, due = (g[f"{item.name}[1]"] if item is not jitter.DUE else g[item.name]
                         for item in (jitter.ACTING, jitter.WAITING, jitter.DUE))  # fmt: skip
    arrived = g["tau_right"]
    given = (
        h > 0, g["actuator.jitter"] == t.most * h, between(0, t.drawn, t.most),
        t.phase >= 0, t.steps >= 1, t.steps >= t.phase + 1,
        t.steps >= due, due >= 0, when(t.phase > 0, last == arrived),
        (acting - last) * (acting - mutation(t.older, t.older + 1)) == 0,
        when(logic_and(t.phase <= 0, due < t.steps), acting == last),
    )  # fmt: skip
    one_of = (now - arrived) * (now - if_else(t.phase <= 0, last, t.older)) == 0
    goals = one_of, waiting == arrived, when(t.phase >= wait, now == arrived)
    return g.states(goals, given=given, cuts=g.cuts, more=t)


@claim("corridor.ramp")
def ramped(mutation: Mutation) -> Statement:
    """a ramp of each axis moves towards its goal and not past it: in a plant step by at least a h,
    or by the rest of the way, or to 0 if the sign must change.

    Between two commands the acting velocity lies between them, and it reaches the second one in
    time.

    Given: h, a > 0; a at most accel and decel.
    """
    g = EffectGraph(command_ramp.COMMAND_RAMP, {"base.accel": [1.0, 1.0]})
    a, goals = symbols("a", "a"), Group()
    h, given = g["clock.plant"], Group()
    for i in (0, 1):
        now, wanted = g[f"{command_ramp.RAMPED.name}[{i + 1}]"], g.system.u[i]
        after, rates = g.system.y[i], [g[f"base.{x}[{i + 1}]"] for x in ("accel", "decel")]
        given += [rate >= a["a"] for rate in rates]
        goals.append((after - now) * (wanted - after) >= 0)
        taken = fmax(abs(wanted - now) - mutation(1, 1.1) * a["a"] * h, 0) >= abs(wanted - after)
        goals.append(when(now * wanted >= 0, taken))
        goals.append(when(logic_and(now * wanted < 0, after != 0), taken))
    goals += every(g.system.update, g.system.y)
    return g.states(goals, given=(positive(h, a["a"]), given), more=a)


@claim("corridor.reckoning")
def reckoning(mutation: Mutation) -> Statement:
    """after a period of dead reckoning the second pose's heading error is still b, and its position
    error has changed by T v times the difference of both directions.

    An initial error of a dead-reckoned pose persists, and its heading error does not grow.

    Given: two poses, the second off by (dx, dy, b); one velocity.
    """
    t = symbols("x y theta dx dy b v omega T s c s_off c_off")
    there, off = vertcat(t.x, t.y, t.theta), vertcat(t.dx, t.dy, t.b)
    v = vertcat(t.v, t.omega)
    first, second = (reckoned(pose, v, t.T) for pose in (there, there + off))
    turned = t.T * t.omega
    cuts = {
        "s": sin(t.theta + turned), "c": cos(t.theta + turned),
        "s_off": sin(t.theta + t.b + turned),
        "c_off": cos(t.theta + t.b + turned),
    }  # fmt: skip
    way = mutation(1, 2) * t.T * t.v
    apart = vertcat(-way * (t.s_off - t.s), way * (t.c_off - t.c), 0)
    return Statement(t, every(second - first, off + apart), (), cuts)
