"""The guard behind a lag that varies: what may be felt, and a safe force at every state.

Exponentials are symbols with what is true of them; the sums may be those of any number of commands.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import casadi as ca

from wmr_ctrl.guard.delay import InFlight, Lagging, integral, moved, push, waiting
from wmr_ctrl.guard.guard import Bounds
from wmr_ctrl.proofs.claim import Claims, Mutation
from wmr_ctrl.proofs.claims.guard_latest import CAPS, LatestAxis, rooms_of
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, equal, symbols

FELT = "z_ahead z_back after_ahead after_back"
LAG = "fast slow falls rises_by rise_J rise rise_late most"
EXPONENTIALS = (
    "0 <= a <= b, 0 <= exp(-J/a) <= exp(-J/b) <= 1, b (1 - exp(-J/b)) <= J, c(t) = (b - a)(1 - "
    "exp(-t/a)): 0 <= c(T) <= c(T + J) <= b - a"
)
MORE = (
    "b Z + M_min again + c(T) max(S - Z_J, 0) and b Z + c(T + J) max(S - Z, 0) + J S at most (b + "
    "J) S (guard.varying.more)"
)


@dataclass(frozen=True)
class VaryingAxis(LatestAxis):
    """One axis behind a lag in [fast, slow]; what is felt when the new command may take over."""

    @cached_property
    def symbols(self) -> dict[str, ca.SX]:
        """Every number by name."""
        own = symbols(f"{FELT} {LAG} again_ahead again_back", LAG)
        return {**LatestAxis(varies=self.varies).symbols, **own}

    @cached_property
    def again(self) -> InFlight:
        """What the last command adds where the new one comes late, as symbols."""
        return InFlight(self["again_ahead"], self["again_back"])

    @property
    def slow(self) -> Lagging:
        """What is felt then and later."""
        now = self["z_ahead"], self["z_back"]
        after = (self["after_ahead"], self["after_back"]) if self.varies else now
        return Lagging(now, after, self["rise"], self["rise_late"])

    @cached_property
    def bounds(self) -> Bounds:
        """What the guard's graph reads: all is mixed."""
        return replace(super().bounds, mixed=self["mixed"])

    @property
    def mixed(self) -> ca.SX:
        """Time in which either of two commands may act."""
        return self["mixed"]

    @property
    def coming(self) -> InFlight:
        """What is under way, as its sums."""
        rest = InFlight(self["rest_ahead"], self["rest_back"])
        again = self.again if self.varies else None
        return InFlight(self["ahead"], self["back"], rest, again, self.slow)

    @property
    def S(self) -> ca.SX:
        """Most that any command pushes."""
        return self.largest + self.net

    @property
    def numbers(self) -> tuple[Relation, ...]:
        """What is true of the exponentials."""
        a, b, J = self["fast"], self["slow"], self.J
        falls, rises = self["falls"], self["rises_by"]
        return (
            at_least(a), at_least(b, a), above(b), at_least(rises), at_least(falls, rises),
            at_least(ca.SX(1), falls), at_least(J, b * (1 - falls)),
            equal(self["rise_J"], (b - a) * (1 - rises)), at_least(self["rise"]),
            at_least(self["rise_late"], self["rise"]), at_least(b - a, self["rise_late"]),
        )  # fmt: skip

    def lasts(self, way: int) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Z now and later, and M_min times what the last command adds, of one direction."""
        names = ("z_ahead", "after_ahead", "again_ahead") if way > 0 else (
            "z_back", "after_back", "again_back",
        )  # fmt: skip
        z, after, again = (self[name] for name in names)
        if not self.varies:
            return z, z, ca.SX(0)
        return z, after, again * self.bounds.M_min

    def more(self, way: int) -> tuple[Relation, ...]:
        """What guard.varying.more says of one direction."""
        z, after, again = self.lasts(way)
        b, J, most = self["slow"], self.J, self["most"]
        return (
            at_least(z), at_least(most, z), at_least(after), at_least(most, after),
            at_least(again), above(most),
            at_least((b + J) * most, b * z + again + self["rise"] * (most - after)),
            at_least(b * most, b * z + self["rise_late"] * (most - z)),
        )  # fmt: skip


Twin = TypeVar("Twin", bound=Callable[..., Statement])


def _core(a: VaryingAxis, way: int, room: ca.SX, most: ca.SX) -> ca.SX:
    """M_min room less all that the last and the new command, of at most ``most``, may do."""
    return a.bounds.M_min * room + a["slow"] * a.lasts(way)[0] - (a["slow"] + a.J) * most


STEADY = r"varying\.(spare|left|room|feasible|counts)\b"
"""Entries that have a kin for a delay that does not vary."""


def twice(
    claim: Claims, name: str, given: str, premises: str = "", back: bool = False
) -> Callable[[Twin], Twin]:
    """Enter the function as a claim with jitter and as one without, whose graph is another.

    ``back``: the same once more about -v.
    """

    def enter(function: Twin) -> Twin:
        id, without = f"guard.varying.{name}", f"guard.varying.steady.{name}"
        calm = re.sub(STEADY, r"varying.steady.\1", premises)
        wording = f"{id} for a delay that does not vary, J = 0"
        claim(id, given=given, premises=premises)(function)
        claim(without, given=given, premises=calm, wording=wording, varies=False)(function)
        if back:
            tables = ((id, premises, True), (without, calm, False))
            for forwards, rests, varies in tables:
                claim(
                    f"{forwards}-back", given=given, premises=rests, wording=f"{forwards} for -v",
                    varies=varies, way=-1,
                )(function)  # fmt: skip
        return function

    return enter


claim = Claims(by=Z3(effort=400))


@claim("guard.varying.moved", given="0 <= exp(-h/a) <= exp(-h/b) <= 1, Z0, p >= 0")
def guard_varying_moved(mutation: Mutation) -> Statement:
    """Z after a piece of time is at least p + e (Z0 - p) for every e between exp(-h/a) and
    exp(-h/b), lies between Z0 and p, and does not fall where Z0 or p rises.

    Z falls latest with b and rises soonest with a.
    """
    t = symbols("z p more_z more_p falls rises between")
    z, p, falls, rises, between = (t[k] for k in ("z", "p", "falls", "rises", "between"))
    first = moved(z, p, (falls, rises))
    second = moved(t["more_z"], t["more_p"], (falls, rises))
    goals = (
        at_least(mutation(1, 0.99) * second, first), at_least(first, p + between * (z - p)),
        at_least(ca.fmax(z, p), first), at_least(first, ca.fmin(z, p)),
    )  # fmt: skip
    given = (
        at_least(z), at_least(p), at_least(t["more_z"], z), at_least(t["more_p"], p),
        at_least(rises), at_least(between, rises), at_least(falls, between),
        at_least(ca.SX(1), falls),
    )  # fmt: skip
    return Statement(t, goals, given)


@claim("guard.varying.integral", given="where every age counts in full; exponentials free")
def guard_varying_integral(mutation: Mutation) -> Statement:
    """b Z + its integral = b Z0 + h p + (b - a)(1 - exp(-h/a)) max(p - Z0, 0).

    What a piece adds beyond a constant lag b.
    """
    t = symbols("z p time fast slow falls rises")
    z, p, time, a, b, falls, rises = t.values()
    weights = (time, b * (1 - falls), a * (1 - rises))
    whole = b * moved(z, p, (falls, rises)) + integral(z, p, weights)
    goal = equal(whole, b * z + waiting(z, p, time, (b - mutation * a) * (1 - rises)))
    return Statement(t, (goal,))


@claim(
    "guard.varying.piece",
    given="0 <= Z0, p <= S, weights of the differences within 0 and that of p",
)
def piece(mutation: Mutation) -> Statement:
    """the weighted integral of Z over a piece is between 0 and its weight times S.

    So all pieces together count for no more than behind a constant lag b.
    """
    t = symbols("z p most time fall rise")
    z, p, most, time, fall, rise = t.values()
    counted = integral(z, p, (time, fall, rise))
    given = [at_least(item) for item in (z, p, fall, rise)]
    given += [at_least(most, z), at_least(most, p), at_least(time, fall), at_least(time, rise)]
    return Statement(
        t, (at_least(mutation(1, 0.99) * time * most, counted), at_least(counted)),
        tuple(given),
    )  # fmt: skip


@claim("guard.varying.more", given=f"0 <= Z, p_1 <= S; {EXPONENTIALS}")
def guard_varying_more(mutation: Mutation) -> Statement:
    """b Z + what the last command adds within J + c(T) (S - Z_J) <= (b + J) S, and b Z + c(T + J)
    (S - Z) <= b S.

    The last command and the new one together count for no more than b + J of the largest.
    """
    a = VaryingAxis()
    z, most, p = a["z_ahead"], a["most"], push([a["sent"]], a.bounds, 1)
    again = waiting(z, p, a.J, a["rise_J"])
    after = moved(z, p, (a["falls"], a["rises_by"]))
    b, more = a["slow"], mutation(1, 0.99)
    goals = (
        at_least(more * (b + a.J) * most, b * z + again + a["rise"] * (most - after)),
        at_least(b * most, b * z + a["rise_late"] * (most - z)), at_least(again),
    )  # fmt: skip
    given = (*a.numbers, above(a.J), at_least(z), at_least(most, z), at_least(most, p), above(most))
    return Statement(a.symbols, goals, given)


@twice(
    claim,
    "spare",
    given="sums without b Z at most (late - J - b) S in rest and (usual - J - b) S in the mean, "
    f"each way (guard.varying.piece); mixed = usual; {CAPS}",
    premises="guard.late.caps guard.varying.piece",
)
def spare(mutation: Mutation, varies: bool = True) -> Statement:
    """core >= max(brakes + net, 0)/alpha ahead, or behind, or for both together, core = M_min (u1 -
    reached) + b Z - (b + J) S.

    The caps leave what braking needs, also where both directions are full.
    """
    a = VaryingAxis(varies=varies)
    b, b_lag, S = a.bounds, a["slow"], a.S
    cores, given = (
        [],
        [at_least(a["usual"], a.J + b_lag), equal(a.mixed, a["usual"]), at_least(b_lag)],
    )
    for way, name, coming in ((1, "ahead", a.coming), (-1, "back", a.coming.mirrored)):
        z = a.lasts(way)[0]
        reached = coming.reached(ca.fmax(way * a["y"] + b.nbar, b.f_speed), b)
        cores.append(_core(a, way, b.u1 - reached, S))
        for sums, time in ((a[name], a["usual"]), (a[f"rest_{name}"], a["delay"])):
            given.append(at_least((time - a.J - b_lag) * S + b_lag * z, b.M_min * sums))
    need = mutation(1, 1.01) * ca.fmax(b.braking + a.net, 0) / b.alpha
    goal = at_least(ca.fmax(ca.fmax(*cores), cores[0] + cores[1]), need)
    rules = (*a.sound(), *a.capped, a.shared(), a.apart(), *given)
    return Statement(a.symbols, (goal,), rules, a.cuts)


@twice(claim, "left", given=MORE, premises="guard.varying.more")
def left(mutation: Mutation, varies: bool = True) -> Statement:
    """M_min room >= min(core, S/alpha), core = M_min (u1 - reached) + b Z - (b + J) S.

    Every line is a mean of core and S/alpha.
    """
    a = VaryingAxis(varies=varies)
    b, room, most = a.bounds, symbols("room")["room"], a["most"]
    left, core = b.M_min * a.coming.left(room, b), _core(a, 1, room, most)
    goal = at_least(left, mutation(1, 1.01) * ca.fmin(core, most / b.alpha))
    given = (
        *a.more(1), *a.numbers, above(b.M_min), above(b.alpha), *([above(a.J)] * varies),
    )  # fmt: skip
    return Statement({**a.symbols, "room": room}, (goal,), given)


@twice(
    claim,
    "room",
    given="guard.varying.left, guard.varying.spare; S >= brakes + net",
    premises="guard.varying.left guard.varying.spare",
)
def guard_varying_room(mutation: Mutation, varies: bool = True) -> Statement:
    """M_min alpha room >= max(brakes + net, 0) ahead, or behind, or for both together.

    What was sent never takes the room that braking needs.
    """
    a = VaryingAxis(varies=varies)
    b, t = a.bounds, symbols("room_ahead room_back core_ahead core_back brakes")
    rooms, cores = (t["room_ahead"], t["room_back"]), (t["core_ahead"], t["core_back"])
    need = ca.fmax(t["brakes"] + a.net, 0) / b.alpha

    def most(pair: tuple[ca.SX, ca.SX]) -> ca.SX:
        return ca.fmax(ca.fmax(*pair), pair[0] + pair[1])

    lines = [
        at_least(b.M_min * room, ca.fmin(core, a["most"] / b.alpha))
        for room, core in zip(rooms, cores, strict=True)
    ]
    given = (
        *lines, at_least(most(cores), need), at_least(a["most"], need * b.alpha), above(b.M_min),
        above(b.alpha),
    )  # fmt: skip
    goal = at_least(b.M_min * most(rooms), mutation(1, 1.01) * need)
    return Statement({**a.symbols, **t}, (goal,), given)


@twice(
    claim,
    "feasible",
    given="guard.varying.room, 2 nbar <= u1, alpha T <= 1",
    premises="guard.varying.room guard.late.caps",
)
def feasible(mutation: Mutation, varies: bool = True) -> Statement:
    """lo(y) <= hi(y) for every y, whatever was sent.

    There is always a safe force: nothing has to be checked while it runs.
    """
    a = VaryingAxis(varies=varies)
    b, t = a.bounds, symbols("room_ahead room_back")
    cuts = {**a.cuts, **dict(zip(t, rooms_of(a), strict=True))}
    both = ca.fmax(ca.fmax(*t.values()), t["room_ahead"] + t["room_back"])
    enough = at_least(mutation(1, 1.01) * b.M_min * b.alpha * both, ca.fmax(b.braking + a.net, 0))
    given = (*a.sound(), *a.capped, enough)
    return Statement({**a.symbols, **t}, (at_least(a.hi, a.lo),), given, cuts)
