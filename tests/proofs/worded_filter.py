"""Entries of filter and gate, and the corridor's assumptions on commands, sampled as worded."""

from functools import partial

import casadi as ca
import numpy as np

from tests.proofs.worded import (
    SAMPLES,
    about,
    around,
    between,
    calculated,
    evaluated,
    left,
    positive,
    same,
    several,
    share,
    signed,
    ways,
)
from wmr_ctrl.control.filter import gate, governor, held_loop
from wmr_ctrl.control.filter.asked import for_base
from wmr_ctrl.control.filter.band import BandGovernor
from wmr_ctrl.control.filter.channels import Channel, scaled
from wmr_ctrl.control.filter.clip import Clip
from wmr_ctrl.control.filter.forecast import Fading, spread_of, stays_of
from wmr_ctrl.control.filter.governor_step import Governor
from wmr_ctrl.world.scenario import load_scenario

PERIOD, SPARE = 0.1, 1 - 2.0**-26
BASE = {
    "filter.kind": "governor", "filter.tau": (0.2, 0.3), "filter.gain": (0.9, 1.1),
    "filter.d": (0.05, 0.05), "filter.odometry": (0.02, 0.02), "clock.control": PERIOD,
}  # fmt: skip
APART = {"filter.tau": ((0.2, 0.3), (0.1, 0.4)), "filter.gain": ((0.9, 1.1), (0.8, 1.2))}
"""Bounds of v and of omega, each for itself; wheels have no such."""
CLIP = {key: value for key, value in BASE.items() if key != "filter.odometry"} | {
    "filter.kind": "clip"
}
LINEAR = {"filter.kind": "clip", "filter.loop": "second-order", "filter.damping": (0.5, 1.0),
          "filter.frequency": (4.0, 5.0), "clock.control": PERIOD}  # fmt: skip
SCALES = ("curvature", "axes", "turn", "drive")
WHEELS, BESIDE = {"filter.channels": "wheels"}, {"filter.wheel_speed": 1.0}


def shapes_of(more):
    """Settings with each way of scaling; wheels are not scaled axis by axis."""
    return [{**more, "filter.scale": way} for way in SCALES if not more or way != "axes"]


def joined(found):
    """Goals of several shapes, each under its own name."""
    return {f"{name} {k}": item for k, own in enumerate(found) for name, item in own.items()}


class Numbers:
    """Random numbers for the ports of a System, by name and place."""

    def __init__(self, rng, system):
        self.system, self.rng, self.of = system, rng, {}
        for item in (*system.inputs, *system.state, *system.params):
            self.of[item.signal.name] = [around(rng, 1.0) for _ in range(item.sym.numel())]

    def bases(self, push, speed):
        """Sound numbers of the filter; the gains of v and of omega."""
        self.of |= {"filter.d": list(push), "limits.v_u1": list(speed)}
        return self.ends("filter.gain")

    def ends(self, name):
        """New random intervals of v and of omega, as one or as two."""
        apart = []
        for _ in range(len(self.of[name]) // 2):
            low = positive(self.rng)
            apart.append((low, low * (1 + share(self.rng))))
        self.of[name] = [end for pair in apart for end in pair]
        return [apart[0], apart[-1]]

    def results(self, *outputs):
        """Outputs for each sample."""
        ports = (*self.system.inputs, *self.system.state, *self.system.params)
        symbols = [x for item in ports for x in ca.vertsplit(ca.vec(item.sym))]
        numbers = [x for item in ports for x in self.of[item.signal.name]]
        return evaluated(
            symbols, [x for out in outputs for x in ca.vertsplit(ca.vec(out))], numbers
        )


def stated(rng, n):
    """V of v and omega, pushes below them, and the gains of each, stored in the numbers."""
    speed = several(rng, 2)
    push = [0.999 * share(rng) * SPARE * V for V in speed]
    return [V * SPARE for V in speed], push, n.bases(push, speed)


@about("filter.drive", "filter.inside", "filter.clip", "filter.contains-clip", "filter.necessary",
       "filter.estimate")  # fmt: skip
def one_axis(rng):
    V, low = several(rng, 2)
    high = low * (1 + share(rng))
    dbar = 0.999 * V * share(rng)
    u, v_bar = around(rng, 2 * V / low), V - around(rng, V) ** 2 / V
    e = np.clip(share(rng), 1e-6, 1 - 1e-6)

    def formula(u, v, V, d, k, K, kap):
        b = governor.FirstOrder(V, d, ca.SX(0), k, K, kap)
        hi, clip = governor.largest_command(v, b), governor.largest_command(V, b)
        return [governor.drive(u, b), governor.drive_back(u, b), hi, clip]

    kappa = e / (1 - e)
    ahead, back, hi, clip = calculated(formula, u, v_bar, V, dbar, low, high, kappa)
    K, d = between(rng, low, high), dbar * signed(rng)
    size = (np.abs(high * u), V)
    found = {
        "drive": left(ahead, K * u + d, *size), "back": left(back, d - K * u, *size),
        "most": left(np.maximum(high * u, 0) + dbar, ahead, *size),
        "contains": left(hi, (V - dbar) / high, kappa * V / high),
    }  # fmt: skip
    E, v = between(rng, e, np.ones(SAMPLES)), v_bar - positive(rng) * share(rng)
    for name, most, share_left, start in (
        ("inside", hi, E, v),
        ("clip", clip, share(rng), V - V * share(rng)),
    ):
        sent = np.where(u <= most, u, most)
        mean = np.maximum(high * sent, low * sent) + dbar - positive(rng) * share(rng)
        sizes = (np.abs(start), np.abs(mean), np.abs(v_bar))
        found[name] = left(V, share_left * start + (1 - share_left) * mean, *sizes)
    beyond = np.maximum(hi, 0) * (1 + 1e-7) + 1e-7 * V / high
    found["necessary"] = left(e * v_bar + (1 - e) * (high * beyond + dbar), V, kappa * V)
    w, target = around(rng, V), around(rng, V)
    most, least = np.maximum(e, E), np.minimum(e, E)
    part = between(rng, least, most)
    (end,) = calculated(lambda w, t, m, l: [governor.relaxed(w, t, m, l)], w, target, most, least)
    v, mean = w - V * share(rng), target - V * share(rng)
    found["estimate"] = left(end, v + part * (mean - v), V, w, target)
    return found


def axes_of(more):
    """Return bounds by axis, if no wheel is limited."""
    return APART if {"filter.channels", "filter.wheel_speed"}.isdisjoint(more) else {}


def _governed(rng, more):
    """Sample a governor's whole step: the commands, the speeds they cause, and the kept bounds."""
    graph = Governor(load_scenario("paper-simulation", {**BASE, **axes_of(more), **more}))
    n = Numbers(rng, graph.system)
    V, push, gain = stated(rng, n)
    T, taus = PERIOD * positive(rng), n.ends("filter.tau")
    H = graph.plans[0].longest * T
    l, error = positive(rng), [0.3 * x * share(rng) for x in V]
    n.of |= {"clock.control": [T], "filter.odometry": error}
    n.of |= {"robot.l": [l]} if "robot.l" in n.of else {}
    if "filter.wheel_speed" in n.of:
        n.of["filter.wheel_speed"] = [(push[0] + l * push[1]) / SPARE * (1 + positive(rng))]
    wheels, beside = "filter.channels" in more, "filter.wheel_speed" in n.of
    W = np.minimum(V[0], l * V[1]) if wheels else None
    if beside:
        W = n.of["filter.wheel_speed"][0] * SPARE
    if wheels:
        push = [0.99 * W * part / 2 / scale for part, scale in ((share(rng), 1), (share(rng), l))]
        n.of["filter.d"] = push
    speeds = [x * signed(rng) for x in V]
    if W is not None:
        size = np.abs(speeds[0]) + l * np.abs(speeds[1])
        speeds = [x * np.minimum(1, W / size) for x in speeds]
    parts = [(1, 0, V[0], push[0]), (0, 1, V[1], push[1])] * (not wheels)
    owners = [0, 1] * (not wheels) + [0, 0] * (W is not None)
    total = push[0] + l * push[1]
    parts += [(1, way * l, W, total) for way in (1, -1)] * (W is not None)
    own = [a * speeds[0] + b * speeds[1] for a, b, _, _ in parts]
    late = rng.integers(0, 2, SAMPLES) == 0
    n.of["elapsed"] = [np.where(late, 3 * T, rng.choice([0.0, 1.0], SAMPLES) * T)]
    known = np.where(late, around(rng, V[0]), 0)
    for name, way in (("v_above", 1), ("v_below", -1)):
        slack = [positive(rng) * share(rng) for _ in own]
        n.of[name] = [np.where(late, known, way * w + x) for w, x in zip(own, slack, strict=True)]
    if "in_time" in n.of:
        n.of["in_time"] = [np.where(late, 0.0, float(graph.oldest))]
    n.of["odometry_age"] = [np.where(share(rng) < 0.5, 0.0, -1.0)]
    n.of["v_odometry"] = [v + e * signed(rng) for v, e in zip(speeds, error, strict=True)]
    n.of["v_asked"] = [around(rng, 3 * x / K[0]) for x, K in zip(V, gain, strict=True)]
    limits = [x for side in graph.limits for x in side]
    outputs = n.results(graph.sent, ca.vertcat(*limits), graph.system.update)
    u, count = outputs[:2], len(parts)
    most, later = outputs[2 : 2 + 2 * count], outputs[2 + 2 * count :]
    found = {}
    for i, (a, b, top, dbar) in enumerate(parts):
        (low, high), (quick, slowest) = gain[owners[i]], taus[owners[i]]
        E = between(rng, np.exp(-H / quick), np.ones(SAMPLES))
        gone = between(rng, -np.expm1(-T / slowest), -np.expm1(-T / quick))
        for side, way in enumerate((1, -1)):
            limit, w = most[side * count + i], way * own[i]
            sent = way * (a * u[0] + b * u[1])
            sizes = (np.abs(a * u[0]), np.abs(b * u[1]), top / low)
            found[f"positive {i} {way}"] = left(limit, 0 * limit, top)
            found[f"sent {i} {way}"] = left(limit, sent, *sizes)
            K, d = between(rng, low, high), dbar * signed(rng)
            mean = K * limit + d
            found[f"inside {i} {way}"] = left(top, E * w + (1 - E) * mean, mean)
            if not more:
                mean = K * sent + d
                end = w + gone * (mean - w)
                found[f"kept {i} {way}"] = left(later[side * count + i], end, top, mean)
    return found


@about("filter.limits", "filter.sent", "filter.assembled", "filter.carried", "filter.step")
def governed(rng):
    return _governed(rng, {})


@about("filter.sent")
def governed_axes(rng):
    return joined(_governed(rng, more) for more in shapes_of({}))


@about("filter.sent", "filter.rims")
def governed_wheels(rng):
    return joined(_governed(rng, more) for more in shapes_of(WHEELS))


@about("filter.sent", "filter.rims")
def governed_beside(rng):
    return joined(_governed(rng, more) for more in shapes_of(BESIDE))


@about("filter.assembled.late")
def governed_late(rng):
    times = {"filter.jitter": PERIOD / 2, "filter.losses": 2, "filter.hold": 5 * PERIOD}
    return joined(_governed(rng, {key: value}) for key, value in times.items())


def clip_of(rng, settings):
    """A clip, and positive numbers for all of its inputs and parameters."""
    clip = Clip(load_scenario("paper-simulation", settings))
    n = Numbers(rng, clip.system)
    n.of = {name: [np.abs(x) + 1e-3 for x in columns] for name, columns in n.of.items()}
    return clip, n


def _clipped(rng, settings):
    """Compare the limited speeds that a clip's commands cause with the numbers of their limits."""
    clip, n = clip_of(rng, {**settings, **axes_of(settings)})
    if "filter.gain" in n.of:
        stated(rng, n)
    else:
        n.of["filter.delta"] = [V * share(rng) * SPARE for V in n.of["limits.v_u1"]]
    n.of["v_asked"] = [around(rng, 3.0) for _ in range(2)]
    both = [
        x
        for channel in clip.channels
        for x in (
            channel.of(clip.sent),
            channel.bounds.K_max,
            channel.bounds.dbar,
            channel.bounds.V,
        )
    ]
    rows = n.results(ca.vertcat(*both, clip.sent))
    size = np.abs(rows[-2]) + np.abs(rows[-1] * n.of.get("robot.l", [1.0])[0])
    found = {}
    for i in range(len(clip.channels)):
        w, K, dbar, V = rows[4 * i : 4 * i + 4]
        reached = K * np.abs(w) + dbar
        found[str(i)] = np.where((dbar < V) & (dbar >= 0), left(V, reached, K * size), 0)
    return found


@about("filter.least")
def least_commands(rng):
    """Consecutive commands, from rest and from random admissible states."""
    small = {"filter.least": True, "base.deadband": (0.03, 0.3), "filter.scale": "axes"}
    scenario = load_scenario("paper-simulation", CLIP | small)
    clip = Clip(scenario)
    n = Numbers(rng, system := for_base(clip.system, scenario))
    stated(rng, n)
    bands = n.of["base.deadband"] = several(rng, 2)
    n.of["deadband_rest"] = [b * signed(rng) for b in bands]
    n.of["deadband_way"] = [rng.choice([-1.0, 0.0, 1.0], SAMPLES) for _ in range(2)]
    n.of["v_asked"] = [around(rng, 1.0) for _ in range(2)]
    rows = n.results(system.y[:2], system.update[:2], ca.vertcat(*clip.limits))
    found = {}
    for i, (band, u, rest, most) in enumerate(
        zip(bands, rows[:2], rows[2:4], rows[4:], strict=True)
    ):
        acts = (u == 0) | (np.abs(u) >= band) | (most < band * (1 + 2.0**-25))
        found |= {f"within {i}": left(most, np.abs(u)), f"acts {i}": np.where(acts, 0.0, -1.0)}
        found[f"rest {i}"] = left(band * (1 + 2.0**-26), np.abs(rest))
    return found


@about("filter.sent-clip")
def clips(rng):
    shapes = [*shapes_of({}), *shapes_of(WHEELS), *shapes_of(BESIDE)]
    return joined(_clipped(rng, {**loop, **more}) for loop in (CLIP, LINEAR) for more in shapes)


@about("filter.slew-sent.together")
def slow(rng):
    found = {}
    for scale in SCALES:
        settings = {**LINEAR, **APART, "filter.slew": (0.1, 0.1), "filter.scale": scale}
        clip, n = clip_of(rng, settings)
        T = positive(rng)
        n.ends("filter.gain")
        n.of["clock.control"] = [T]
        slew, V = n.of["filter.slew"], n.of["limits.v_u1"]
        n.of["filter.slew_reach"] = [v * share(rng) / a / 2 for v, a in zip(V, slew, strict=True)]
        n.of["filter.delta"] = [v * share(rng) * 0.49 for v in V]
        n.of["elapsed"] = [around(rng, T)]
        (limits,) = [n.results(ca.vertcat(*clip.limits))]
        before = n.of["v_last"] = [x * signed(rng) for x in limits]
        n.of["v_asked"] = [around(rng, 3 * x) for x in limits]
        u1, u2, time = n.results(clip.sent, clip.time)
        for name, u, was, most, a in zip("12", (u1, u2), before, limits, slew, strict=True):
            found[f"inside {name} {scale}"] = left(most, np.abs(u))
            found[f"slow {name} {scale}"] = left(a * time, np.abs(u - was), most)
        found[f"time {scale}"] = np.minimum(left(T, time), time)
    return found


@about("filter.band.sent")
def bands(rng):
    loop = {**LINEAR, "filter.kind": "band"}
    pi = {"filter.kind": "band", "filter.loop": "pi", "clock.control": PERIOD,
          "filter.mass": (50.0, 65.0), "filter.inertia": (4.0, 6.0), "filter.kp": (135.0, 165.0),
          "filter.ki": (270.0, 330.0)}  # fmt: skip
    found = {}
    for k, more in enumerate((*({**loop, **shape} for shape in shapes_of({})), pi)):
        graph = BandGovernor(load_scenario("paper-simulation", more))
        n = Numbers(rng, graph.system)
        ends = [x for pair in graph.ends for x in pair]
        limits = ca.vertcat(*ends, *graph.stopping, graph.sound)
        rows = n.results(graph.sent, ca.vertcat(*graph.command), limits)
        u, asked, own, stops, sound = rows[:2], rows[2:4], rows[4:8], rows[8:10], rows[10]
        for i in (0, 1):
            low, high = own[2 * i], own[2 * i + 1]
            met = (sound > 0) & (own[0] <= own[1]) & (own[2] <= own[3])
            inside = np.minimum(left(high, u[i], low), left(u[i], low, high))
            found[f"ends {i} {k}"] = np.where(met, inside, 0)
            around_0 = (own[0] <= 0) & (own[1] >= 0) & (own[2] <= 0) & (own[3] >= 0)
            stop = np.minimum(left(stops[i], np.abs(u[i])), np.sign(u[i]) * np.sign(asked[i]))
            found[f"stop {i} {k}"] = np.where(met & around_0, stop, 0)
    return found


@about(
    "filter.curvature",
    "filter.wheel-box",
    "filter.ramp-rim",
    "filter.held-share",
    "filter.band.beat",
    "filter.band.fading",
    "filter.band.past",
)
def parts(rng):
    r = [around(rng, 2.0) for _ in range(2)]
    hi, lo = (several(rng, 2) for _ in range(2))

    def factor(a, b, *ends):
        back = [-x for x in ends[2:]]
        return [ca.fmin(*governor.admitted([a, b], back, list(ends[:2])))]

    (eta,) = calculated(factor, *r, *hi, *lo)
    found = {"eta": np.minimum(eta - 1e-300, 1 - eta)}
    for k in (0, 1):
        found[f"eta {k}"] = np.minimum(left(hi[k], eta * r[k]), left(eta * r[k], -lo[k]))
    V, l, Omega = several(rng, 3)
    top = np.minimum(V, l * Omega)
    rims = [top * signed(rng) for _ in range(2)]
    v, omega = (rims[0] + rims[1]) / 2, (rims[0] - rims[1]) / 2 / l
    found["box"] = np.minimum(left(V, np.abs(v)), left(Omega, np.abs(omega)))
    shrink, back = several(rng, 2)
    grow, turn = l * back * share(rng), shrink / l * share(rng)
    ends = [[V * signed(rng) for _ in range(2)] for _ in range(2)]
    now, goal = (((a + b) / 2, (a - b) / 2 / l) for a, b in ends)
    after = [
        _ramped(x, y, up, down)
        for x, y, up, down in zip(now, goal, (grow, turn), (shrink, back), strict=True)
    ]
    for way in (1, -1):
        found[f"ramp {way}"] = left(V, np.abs(after[0] + way * l * after[1]), l * np.abs(after[1]))
    held, q = share(rng), share(rng)
    W, part = positive(rng), between(rng, 1 - held, np.ones(SAMPLES))
    (d,) = calculated(lambda x, V: [held_loop.push_of_share(2 * x, V)], held, V)
    start, to = _pair(rng, V, W, l), _pair(rng, V - d, W - d, l)
    ended = start[0] + part * q * (to[0] - start[0]), start[1] + q * (to[1] - start[1])
    met = (d <= V) & (d <= W)
    kept = [left(V, np.abs(ended[0]), W)]
    kept += [left(W, np.abs(ended[0] + way * l * ended[1]), V) for way in (1, -1)]
    found["held"] = np.where(met, np.minimum.reduce(kept), 0)
    before, behind, off = positive(rng), positive(rng), around(rng, 1.0)
    p, w = (between(rng, -before, behind) for _ in range(2))
    b, a = calculated(
        lambda x, y, o: ca.vertsplit(spread_of(ca.vertcat(x, y), o)), before, behind, off
    )
    beats = [left(a, x - off, b) for x in (p, w, off)] + [left(x - off, -b, a) for x in (p, w, off)]
    found["beat"] = np.minimum.reduce([*beats, left(b + a, p - w)])
    reach, past = several(rng, 2)
    came = rng.integers(0, 2, SAMPLES).astype(float)
    x, soonest = positive(rng), share(rng)
    g = share(rng) / (1 + x + x * x / 2)
    g = np.where(came > 0, np.minimum(g, soonest), g)

    def aged(reach, past, came, x, soonest):
        known = Fading(reach, past, ca.SX(0)).aged(came, ca.SX(0), stays_of(x, ca.SX(1)), soonest)
        return [known.reach, known.past]

    fades, rest = calculated(aged, reach, past, came, x, soonest)
    found["fading"] = np.minimum(
        left(fades, reach * share(rng) * g), left(rest, np.where(came > 0, past, reach) * g)
    )
    c, at = positive(rng), around(rng, 1.0)
    over, under = calculated(lambda p, h, c: list(Fading(ca.SX(0), p, h).bounds(c)), past, at, c)
    for way, bound in ((1, over), (-1, under)):
        v = np.minimum(way * at + past, c * (1 + 2.0**-29)) - way * at
        found[f"past {way}"] = np.where(v >= 0, left(bound, v, c, np.abs(at)), 0)
    return found


def _pair(rng, V, W, l):
    """v and omega with |v| <= V and both wheels within W, including the boundaries."""
    v, turn = ways(rng) * share(rng) * np.minimum(V, W), share(rng)
    return v, ways(rng) * turn * (W - np.abs(v)) / l


def _ramped(now, goal, up, down):
    """A ramp's next value: away from 0 by ``up`` at most, towards it by ``down``, not past it."""
    turns = now * goal < 0
    stop = np.where(turns, 0.0, goal)
    most = np.where(np.abs(stop) >= np.abs(now), up, down)
    return now + np.clip(stop - now, -most, most)


@about("gate.inside", "gate.stop", "gate.falls", "gate.rise")
def gates(rng):
    shapes = [*shapes_of({}), *shapes_of(WHEELS), *shapes_of(BESIDE)]
    return joined(_gated(rng, more) for more in shapes)


def _gated(rng, more):
    """A gate's whole step: limits of axes or wheels; ramps and latches where axes have limits."""
    settings = gate.GateSettings()
    scenario = load_scenario("paper-simulation", {**CLIP, **axes_of(more), **more})
    system = gate.gate_system(scenario, settings)
    n = Numbers(rng, system)
    V, push, gain = stated(rng, n)
    l = n.of["robot.l"] = [positive(rng)]
    n.of["filter.wheel_speed"] = [positive(rng)]
    last = n.of["v_last"] = [around(rng, 1.0) for _ in range(2)]
    u, (latched, *_) = n.results(system.y[:2]), n.results(system.update[-3])
    wheels, beside, found = "filter.channels" in more, "filter.wheel_speed" in more, {}
    if not wheels:
        for i in (0, 1):
            found[f"inside {i}"] = left((V[i] - push[i]) / gain[i][1], np.abs(u[i]))
    if wheels or beside:
        top = np.minimum(V[0], l[0] * V[1]) if wheels else n.of["filter.wheel_speed"][0] * SPARE
        most = (top - push[0] - l[0] * push[1]) / gain[0][1]
        for way in (1, -1):
            rim = np.abs(u[0] + way * l[0] * u[1])
            found[f"rim {way}"] = left(most, rim, u[0], l[0] * u[1])
        return {name: np.where(most > 0, item, 0) for name, item in found.items()}
    elapsed, T = n.of["elapsed"][0], scenario.clock.control
    t = np.where(elapsed == 0, T, np.clip(elapsed, 0, T))
    stops = n.of["stop"][0] > 0
    stale = n.of["command_age"][0] > settings.command_timeout
    stays = (n.of["latched"][0] > 0) & (n.of["reset"][0] <= 0)
    for i in (0, 1):
        found[f"stop {i}"] = np.where(stops, -np.abs(u[i]), 0)
        falls = np.maximum(np.abs(last[i]) - settings.fall[i] * t, 0)
        found[f"falls {i}"] = np.where(stale | stays, left(falls, np.abs(u[i]), last[i]), 0)
        found[f"rises {i}"] = left(np.abs(last[i]) + settings.rise[i] * t, np.abs(u[i]))
    return found | {"latched": np.where(stays, -np.abs(latched - 1), 0)}


def _sent_as_it_is(kinds, scale, v, omega, l, A, B, C):
    """A command within limits A of v, B of omega, C of both wheels, scaled."""
    unused = governor.FirstOrder(*(ca.SX(0) for _ in range(6)))
    axes = [Channel((1 - i, i), ca.SX(1), (unused,), (0.0, 0.0)) for i in (0, 1)] * (
        "axes" in kinds
    )
    sides = [Channel((1, way), l, (unused,), (0.0, 0.0)) for way in (1, -1)] * ("wheels" in kinds)
    most = [A, B] * ("axes" in kinds) + [C, C] * ("wheels" in kinds)
    return ca.vertsplit(scaled((v, omega), [*axes, *sides], [-x for x in most], most, scale))


@about("corridor.filter")
def unclipped(rng):
    found = {}
    for kinds in ("axes", "wheels", "axes wheels"):
        for shape in shapes_of({} if kinds == "axes" else WHEELS):
            l, A, B, C = several(rng, 4)
            v, omega = _pair(rng, A, C, l)
            if kinds == "axes":
                v, omega = A * signed(rng), B * signed(rng)
            B = np.maximum(B, np.abs(omega))
            scale = shape["filter.scale"]
            sent = calculated(partial(_sent_as_it_is, kinds, scale), v, omega, l, A, B, C)
            found[f"v {kinds} {scale}"] = same(sent[0], v, C)
            found[f"omega {kinds} {scale}"] = same(l * sent[1], l * omega, C)
    return found
