"""Entries of the guard, sampled as they are worded."""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from tests.proofs.worded import (
    SAMPLES,
    about,
    around,
    between,
    calculated,
    left,
    positive,
    same,
    several,
    share,
    signed,
    ways,
)
from wmr_ctrl.control.guard import delay as late_guard
from wmr_ctrl.control.guard.guard import Bounds, ceiling, clipped, feasible, floor
from wmr_ctrl.control.guard.monitor import least_push

Array = np.ndarray
KEYS = ("u1", "period", "M_min", "M_max", "dbar", "nbar", "alpha", "brake", "f_min", "f_speed")


@dataclass
class Axis:
    """Numbers of one axis that meet the theorem's conditions; times if something is late."""

    numbers: dict[str, Array]
    delay: Array | None = None
    jitter: Array | None = None
    mixed: Array | None = None
    usual: Array | None = None

    def __getattr__(self, name):
        return self.numbers[name]

    @property
    def net(self):
        return self.dbar - self.f_min

    @property
    def size(self):
        """Size of its forces."""
        return self.M_min * self.alpha * self.u1 + np.abs(self.net) + self.brake

    def graph(self, *symbols):
        """The bounds that the product's functions read, of the first symbols."""
        names = [
            *KEYS,
            *(name for name in ("delay", "jitter", "mixed") if vars(self)[name] is not None),
        ]
        return Bounds(**dict(zip(names, symbols, strict=False)))

    @property
    def columns(self):
        """Numbers in the order of `graph`."""
        times = [item for item in (self.delay, self.jitter, self.mixed) if item is not None]
        return [*(self.numbers[name] for name in KEYS), *times]

    def force(self, asked, y, *coming):
        """F, hi, lo and the safe point; ``coming``: ahead, back, then from rest, then the last
        command's.
        """
        count = len(self.columns)

        def formula(*x):
            b, wish, seen, sums = self.graph(*x[:count]), x[count], x[count + 1], x[count + 2 :]
            pushed = None
            if sums:
                rest = late_guard.InFlight(*sums[2:4]) if len(sums) > 2 else None
                again = late_guard.InFlight(*sums[4:6]) if len(sums) > 4 else None
                pushed = late_guard.InFlight(*sums[:2], since_rest=rest, again=again)
            own = (seen, b, pushed)
            return [clipped(wish, *own), ceiling(*own), floor(*own), clipped(ca.SX(0), *own)]

        return calculated(formula, *self.columns, asked, y, *coming)

    def caps(self):
        """Brakes and largest force."""
        count = len(self.columns)

        def formula(*x):
            b = self.graph(*x[:count])
            return [b.braking, late_guard.largest_force(b) if b.delay is not None else b.braking]

        brakes, largest = calculated(formula, *self.columns)
        return brakes, largest


def drawn(rng, late=""):
    """Numbers that meet all conditions, many of them only just; ``late``: "", "delay" or
    "jitter".
    """
    n = {name: positive(rng) for name in ("u1", "period", "M_min")}
    n["alpha"] = (0.02 + 0.98 * share(rng)) / n["period"]
    n["M_max"] = n["M_min"] * (1 + 2 * share(rng))
    n["f_speed"] = 0.98 * share(rng) * n["u1"]
    n["nbar"] = 0.5 * share(rng) * n["u1"]
    axis = Axis(n)
    most = n["M_min"] * n["alpha"] * (n["u1"] - n["f_speed"]) / 2
    if late:
        axis.delay = n["period"] * positive(rng)
        most = most / (1 + n["alpha"] * axis.delay)
    if late == "jitter":
        n["nbar"] *= 0.98
        axis.jitter = n["period"] * np.maximum(share(rng), 1e-3)
        axis.delay = axis.jitter + axis.delay
        axis.usual = between(rng, axis.jitter, axis.delay)
        axis.mixed = between(rng, axis.jitter, axis.usual)
        most = (
            n["M_min"] * n["alpha"] * (n["u1"] - n["f_speed"]) / (2 + 2 * n["alpha"] * axis.delay)
        )
        most = np.minimum(most, n["M_min"] * (n["u1"] - 2 * n["nbar"]) / (2 * axis.mixed))
    net = np.where(rng.integers(0, 3, SAMPLES) == 0, -positive(rng), share(rng)) * most
    n["f_min"] = np.maximum(-net, 0) + positive(rng) * share(rng) * most
    n["dbar"] = net + n["f_min"]
    n["brake"] = np.maximum(n["dbar"] - n["f_min"], 0) + share(rng) * 3 * most
    return axis


def counted(rng, a):
    """Sums of commands in transit as the entries bound them, and the last command's."""
    _, largest = a.caps()
    S, J = largest + a.net, 0 * a.u1 if a.jitter is None else a.jitter
    if a.usual is None:
        most = a.delay * S / a.M_min * share(rng)
        part = share(rng)
        return [part * most, (1 - part) * most]
    rest = [(a.delay - J) * S / a.M_min * share(rng) for _ in range(2)]
    mean = [item * share(rng) for item in rest]
    scale = (a.usual + (0 if a.mixed is None else a.mixed) - 2 * J) * S / a.M_min
    over = np.minimum(1, np.maximum(scale, 0) / np.maximum(mean[0] + mean[1], 1e-300))
    sums = [mean[0] * over, mean[1] * over, *rest]
    if a.jitter is not None:
        last = largest * signed(rng)
        sums += [J * np.maximum(way * last + a.net, 0) / a.M_min for way in (1, -1)]
    return sums


@about(
    "guard.feasible", "guard.anchor", "guard.inside", "guard.kept", "guard.no-overshoot",
    "guard.graceful", "guard.outside", "guard.return"
)  # fmt: skip
def at_once(rng):
    a = drawn(rng)
    v = around(rng, a.u1)
    y = v + a.nbar * between(rng, -np.ones(SAMPLES), np.ones(SAMPLES))
    force, hi, lo, safe = a.force(around(rng, 3 * a.size), y)
    brakes, _ = a.caps()
    mass, t = between(rng, a.M_min, a.M_max), a.period * share(rng)
    found = {"lo <= hi": left(hi, lo, a.size), "anchor": left(brakes, np.abs(safe), a.size)}
    excess = np.minimum(share(rng) * (brakes - a.net) * a.M_min / a.M_max, a.size)
    excess = np.maximum(excess, 0)
    for way in (1, -1):
        start, push = np.maximum(way * v, a.f_speed), way * force + a.net
        end = start + t * np.maximum(push, 0) / mass
        found[f"inside {way}"] = np.where(np.abs(v) <= a.u1, left(a.u1, end), 0)
        over = start + t * np.maximum(push + excess, 0) / mass
        most = a.u1 + excess * a.period / a.M_min
        found[f"graceful {way}"] = np.where(way * v <= most, left(most, over), 0)
        thrown = a.f_speed + t * np.maximum(-way * force + a.net, 0) / mass
        found[f"no overshoot {way}"] = left(a.u1, thrown)
        beyond = way * v - a.u1
        least = np.minimum(brakes - a.net, a.M_max * beyond / a.period)
        sizes = (a.size, a.M_max * beyond / a.period)
        found[f"outside {way}"] = np.where(beyond > 0, left(-push, least, *sizes), 0)
        later = way * v + a.period * push / mass
        back = np.maximum(a.u1, way * v - a.period * (brakes - a.net) / mass)
        found[f"return {way}"] = np.where(beyond > 0, left(back, later, way * v), 0)
    return found


@about(
    "guard.delay.caps", "guard.delay.room", "guard.delay.feasible", "guard.delay.largest",
    "guard.delay.anchor", "guard.delay.inside", "guard.delay.outside", "guard.delay.return",
    "guard.delay.graceful", "guard.delay.kept"
)  # fmt: skip
def delayed(rng):
    return _late(rng, drawn(rng, "delay"))


@about(
    "guard.late.caps", "guard.late.feasible", "guard.late.largest", "guard.late.anchor",
    "guard.late.inside", "guard.late.outside", "guard.late.graceful", "guard.late.left",
    "guard.late.spare", "guard.late.room"
)  # fmt: skip
def jittering(rng):
    return _late(rng, drawn(rng, "jitter"))


@about(
    "guard.late.feasible", "guard.late.steady.room", "guard.late.inside", "guard.late.outside",
    "guard.late.steady.return", "guard.late.graceful", "guard.late.left"
)  # fmt: skip
def averaged(rng):
    a = drawn(rng, "delay")
    return _late(rng, replace(a, usual=a.delay * share(rng)))


def _late(rng, a):
    """Goals with commands in transit: the room they leave, and the limit under the new command."""
    assert a.delay is not None
    (brakes, largest), sums = a.caps(), counted(rng, a)
    J = 0 * a.u1 if a.jitter is None else a.jitter
    m = around(rng, a.u1)
    y = m + a.nbar * between(rng, -np.ones(SAMPLES), np.ones(SAMPLES))
    force, hi, lo, safe = a.force(around(rng, 3 * a.size), y, *sums)
    need = np.maximum(brakes + a.net, 0)
    S = largest + a.net
    room = a.u1 - a.f_speed
    size = (a.size, largest)
    found = {
        "caps": np.minimum.reduce([left(brakes, 0, *size), left(brakes, a.net, *size),
                                   left(largest, brakes, *size)]),
        "shared": left(room, a.delay * S / a.M_min + need / (a.M_min * a.alpha), a.u1),
        "lo <= hi": left(hi, lo, *size), "largest": left(largest, np.abs(force), *size),
        "anchor": left(brakes, np.abs(safe), *size),
    }  # fmt: skip
    if a.mixed is not None:
        found["apart"] = left(a.M_min * (a.u1 - 2 * a.nbar), a.mixed * S)
    mass, rooms = between(rng, a.M_min, a.M_max), []
    since = J * share(rng)
    t = (a.period + J - since) * share(rng)
    excess = np.maximum(share(rng) * (brakes - a.net), 0)
    for k, way in enumerate((1, -1)):
        own = sums[k::2]
        reached = np.maximum(way * m, a.f_speed) + own[0]
        seen = np.maximum(way * y + a.nbar, a.f_speed) + own[0]
        if len(own) > 1:
            reached, seen = (np.maximum(x, a.f_speed + own[1]) for x in (reached, seen))
        again = own[2] if len(own) > 2 else 0 * J
        spare = a.u1 - seen
        rooms.append((spare, np.minimum(spare - again, spare / (1 + a.alpha * J))))
        first = between(rng, a.f_speed, reached)
        start = first + since * again / np.maximum(J, 1e-300) * a.M_min / mass
        push = way * force + a.net
        end = start + t * np.maximum(push, 0) / mass
        found[f"inside {way}"] = np.where(start <= a.u1, left(a.u1, end), 0)
        beyond = start - a.u1
        braking = np.minimum(brakes - a.net, a.M_max * beyond / a.period)
        sizes = (*size, a.M_max * beyond / a.period)
        found[f"outside {way}"] = np.where(beyond > 0, left(-push, braking, *sizes), 0)
        if a.jitter is None:
            back = np.maximum(a.u1, start - a.period * (brakes - a.net) / mass)
            later = start + a.period * push / mass
            found[f"return {way}"] = np.where(beyond > 0, left(back, later, start), 0)
        more = first + excess * (a.delay - J) / a.M_min
        pushed = np.where(J > 0, again / np.maximum(J, 1e-300) * a.M_min + excess, 0)
        over = more + since * pushed / mass
        most = a.u1 + excess * (a.period + a.delay) / a.M_min
        last = over + t * np.maximum(push + excess, 0) / mass
        found[f"graceful {way}"] = np.where(over <= most, left(most, last), 0)
    both = [np.maximum.reduce([one, two, one + two]) for one, two in zip(*rooms, strict=True)]
    found["room"] = left(a.M_min * a.alpha * both[1], need, *size)
    ahead, back = rooms[0][0] * a.M_min, rooms[1][0] * a.M_min
    braking = need / a.alpha
    one = np.maximum(ahead, back) - braking - J * S
    two = ahead + back - braking - 2 * J * S
    found["spare"] = left(np.maximum(one, two), 0 * J, a.M_min * a.u1)
    return found


@about("guard.monitor", "guard.monitor-quiet", "guard.monitor-sharp")
def monitor(rng):
    a = drawn(rng)
    way = ways(rng)
    old, mass = around(rng, 3 * a.u1), between(rng, a.M_min, a.M_max)
    asked, push = around(rng, 2 * a.size), around(rng, 2 * a.size)
    exact = rng.integers(0, 2, SAMPLES) == 0
    mass, drag = np.where(exact, a.M_min, mass), np.where(exact, 0, a.size * share(rng))
    noise, heavy = np.where(exact, 0, a.nbar), np.where(exact, a.M_min, a.M_max)
    a.numbers |= {"nbar": noise, "M_max": heavy}
    new = old + a.period * (asked + way * (push - drag)) / mass
    errors = [noise * signed(rng) for _ in range(2)]
    y, before = new + errors[0], old + errors[1]
    (least,) = calculated(
        lambda *x: [least_push(x[-3], x[-2], x[-1], a.graph(*x))], *a.columns, y, before, asked
    )
    moving = np.minimum(way * y, way * before) > noise
    beyond = np.maximum(np.minimum(y, before), -np.maximum(y, before)) > noise
    sizes = (
        a.size,
        np.abs(asked),
        a.M_max * np.abs(y - before) / a.period,
        a.M_max * np.abs(y) / a.period,
    )
    blamed = left(np.maximum(push, 0), least, *sizes)
    return {
        "not blamed": np.where(moving, blamed, 0), "quiet": np.where(beyond, 0, -np.abs(least)),
        "sharp": np.where(moving & exact & (push >= 0), same(least, push, *sizes), 0),
    }  # fmt: skip


@about("guard.promise")
def flag(rng):
    a = drawn(rng, "delay")
    a.numbers |= {name: a.numbers[name] * rng.choice([1.0, 1.0001, 1.3], SAMPLES) for name in KEYS}
    (told,) = calculated(lambda *x: [feasible(a.graph(*x))], *a.columns)
    need = 2 * a.net * (1 + a.alpha * a.delay)
    met = np.minimum.reduce([
        left(a.M_min * a.alpha * (a.u1 - a.f_speed), need), left(a.u1, 2 * a.nbar),
        left(a.brake, a.net), left(a.M_max, a.M_min), left(a.u1, a.f_speed),
        left(1 + 0 * a.u1, a.alpha * a.period),
    ])  # fmt: skip
    return {"flag": np.where(told > 0, met, 0)}


@about(
    "guard.maximal", "guard.necessary", "guard.lemma.piece", "guard.late.convex",
    "guard.delay.command", "guard.late.piece"
)  # fmt: skip
def forces(rng):
    a = drawn(rng)
    exact = {"nbar": 0 * a.u1, "f_speed": 0 * a.u1, "f_min": 0 * a.u1, "alpha": 1 / a.period}
    dbar = share(rng) * a.M_min * a.u1 / a.period / 2
    b = Axis(a.numbers | exact | {"dbar": dbar, "brake": dbar * (1 + share(rng))})
    v = b.u1 * share(rng)
    _, hi, _, _ = b.force(0 * v, v)
    force = hi + b.size * 1e-6 * positive(rng)
    found = {"maximal": left(v + b.period * (force + dbar) / b.M_min, b.u1)}
    tight = a.M_min * a.u1 / (2 * a.period) * (1 + 1e-6 + positive(rng))
    force = -tight * (1 + share(rng))
    found["necessary"] = left(a.period * (tight - force) / a.M_min, a.u1)
    end, t = around(rng, a.u1), a.period * share(rng)
    start, mass = around(rng, a.u1), between(rng, a.M_min, a.M_max)
    alike = (start - a.f_speed) * (end - a.f_speed) >= 0
    drag, push = a.f_min * (1 + share(rng)), a.dbar * signed(rng)
    acts = mass * (end - start) / np.maximum(t, 1e-9 * a.period) + drag - push
    most = np.maximum(start, a.f_speed) + t * np.maximum(acts + a.net, 0) / a.M_min
    met = alike & (t > 0)
    found["piece"] = np.where(met, left(most, np.maximum(end, a.f_speed)), 0)
    c = drawn(rng, "delay")
    _, largest = c.caps()
    first, second = (largest * signed(rng) for _ in range(2))
    part, w = c.period * share(rng), share(rng)
    for way in (1, -1):
        p, q = (np.maximum(way * x + c.net, 0) for x in (first, second))
        counts = part * np.maximum(p, q) / c.M_min
        acted = part * share(rng) * np.where(w > 0.5, p, q) / c.M_min
        found[f"counted {way}"] = left(counts, acted)
        found[f"most {way}"] = left(
            part * (largest + c.net) / c.M_min, counts, part * c.size / c.M_min
        )
        mixed = np.maximum(way * (w * first + (1 - w) * second) + c.net, 0)
        found[f"convex {way}"] = left(w * p + (1 - w) * q, mixed, c.size)
    both = np.maximum(first + c.net, 0) + np.maximum(c.net - first, 0)
    return found | {"both": left(largest + c.net, both, largest, c.size)}


@about("guard.varying.moved", "guard.varying.integral", "guard.varying.piece", "guard.varying.more")
def lagging(rng):
    b = positive(rng)
    a = b * np.maximum(share(rng), 1e-3)
    h, J = several(rng, 2)
    T = J * (1 + positive(rng))
    most = positive(rng)
    z, p = most * share(rng), most * share(rng)
    falls, rises = np.exp(-h / b), np.exp(-h / a)
    after, taken, added = calculated(
        lambda z, p, f, r, h, b, a: [
            late_guard.moved(z, p, (f, r)),
            late_guard.integral(z, p, (h, b * (1 - f), a * (1 - r))),
            late_guard.waiting(z, p, h, (b - a) * (1 - r)),
        ], z, p, falls, rises, h, b, a,
    )  # fmt: skip
    middle = p + between(rng, rises, falls) * (z - p)
    grown, = calculated(lambda z, p, f, r: [late_guard.moved(z, p, (f, r))],
                        z * (1 + share(rng)), p * (1 + share(rng)), falls, rises)  # fmt: skip
    stays = np.exp(-J / b), np.exp(-J / a)
    z_J, again = calculated(
        lambda z, p, f, r, J, b, a: [
            late_guard.moved(z, p, (f, r)), late_guard.waiting(z, p, J, (b - a) * (1 - r)),
        ], z, p, *stays, J, b, a,
    )  # fmt: skip
    c, c_late = ((b - a) * (1 - np.exp(-t / a)) for t in (T, T + J))
    return {
        "moved": left(after, middle, most), "high": left(np.maximum(z, p), after, most),
        "low": left(after, np.minimum(z, p), most), "grows": left(grown, after, most),
        "integral": same(b * after + taken, b * z + added, b * most, h * most),
        "piece": np.minimum(left(h * most, taken), left(taken, 0 * h, h * most)),
        "more": left((b + J) * most, b * z + again + c * (most - z_J)),
        "late": left(b * most, b * z + c_late * (most - z)),
    }  # fmt: skip
