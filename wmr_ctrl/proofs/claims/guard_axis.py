"""Symbols and hypotheses that the guard's claims share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import casadi as ca

from wmr_ctrl.guard.delay import InFlight, in_flight, largest_force
from wmr_ctrl.guard.guard import Bounds, ceiling, clipped, floor
from wmr_ctrl.proofs.claim import Claims
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, symbols

Directed = TypeVar("Directed", bound=Callable[..., Statement])
NUMBERS = "u1 period M_min M_max dbar nbar alpha brake f_min f_speed"
PRESENT = "v y asked mass t"
LATE = "delay ahead back arrived sent other periods since extra"


@dataclass(frozen=True)
class GuardAxis:
    """Symbols of one axis: the guard's numbers, and what happens in one sample."""

    @cached_property
    def symbols(self) -> dict[str, ca.SX]:
        """Every number by name."""
        return symbols(f"{NUMBERS} {PRESENT}", NUMBERS)

    def __getitem__(self, name: str) -> ca.SX:
        """The symbol of a name."""
        return self.symbols[name]

    @cached_property
    def bounds(self) -> Bounds:
        """What the guard's graph reads."""
        return Bounds(**{name: self[name] for name in NUMBERS.split()})

    @property
    def net(self) -> ca.SX:
        """dbar - f_min, written down here: what the guard subtracts is to be compared with it."""
        return self["dbar"] - self["f_min"]

    @property
    def force(self) -> ca.SX:
        """What the guard lets through."""
        return clipped(self["asked"], self["y"], self.bounds)

    def feasible(self, pushed: float = 1, faster: float = 1) -> tuple[Relation, ...]:
        """The theorem's hypotheses; factors above 1 relax the first and alpha T <= 1."""
        b = self.bounds
        positive = [above(item) for item in (b.u1, b.period, b.M_min, b.alpha)]
        not_negative = [at_least(item) for item in (b.dbar, b.nbar, b.brake, b.f_min, b.f_speed)]
        reach = b.M_min * b.alpha * (b.u1 - b.f_speed)
        return (
            *positive, *not_negative, at_least(b.M_max, b.M_min), above(b.u1, b.f_speed),
            at_least(ca.SX(faster), b.alpha * b.period), at_least(pushed * reach, 2 * self.net),
            at_least(b.u1, 2 * b.nbar), at_least(b.brake, self.net),
        )  # fmt: skip

    @property
    def measured(self) -> tuple[Relation, ...]:
        """|y - v| <= nbar."""
        gap = self["y"] - self["v"]
        return at_least(self["nbar"], gap), at_least(self["nbar"], -gap)

    @property
    def inside(self) -> tuple[Relation, ...]:
        """|v| <= u1."""
        return at_least(self["u1"], self["v"]), at_least(self["v"], -self["u1"])

    @property
    def during(self) -> tuple[Relation, ...]:
        """0 <= t <= T, M_min <= M <= M_max."""
        b, mass = self.bounds, self["mass"]
        return (
            at_least(self["t"]),
            at_least(b.period, self["t"]),
            at_least(mass, b.M_min),
            at_least(b.M_max, mass),
        )

    def farthest(self, way: int, more: ca.SX | float = 0) -> ca.SX:
        """Comparison bound of way * v at time t: max(v, f_speed) + t max(F + net, 0)/M."""
        b = self.bounds
        start = ca.fmax(way * self["v"], b.f_speed)
        return start + self["t"] * ca.fmax(way * self.force + self.net + more, 0) / self["mass"]


@dataclass(frozen=True)
class LateAxis(GuardAxis):
    """One axis behind a delay: any number of commands under way, by what they add up to.

    ``arrived`` bounds v (or -v) at the instant at which the new command starts to act; ``place`` is
    the axis among the two that a command has.
    """

    place: int = 0

    @cached_property
    def symbols(self) -> dict[str, ca.SX]:
        """Every number by name."""
        return symbols(f"{NUMBERS} {PRESENT} {LATE}", f"{NUMBERS} delay")

    @cached_property
    def bounds(self) -> Bounds:
        """What the guard's graph reads."""
        at_once = Bounds(**{name: self[name] for name in NUMBERS.split()})
        return replace(at_once, delay=self["delay"])

    @property
    def coming(self) -> InFlight:
        """What is under way, as its two sums."""
        return InFlight(self["ahead"], self["back"])

    @cached_property
    def one(self) -> InFlight:
        """What is under way where it is a single command ``sent`` for some ``periods``."""
        pair = [self["other"], self["other"]]
        pair[self.place] = self["sent"]
        return in_flight([(ca.vertcat(*pair), self["periods"])], self.place, self.bounds)

    @cached_property
    def largest(self) -> ca.SX:
        """What no command exceeds."""
        return largest_force(self.bounds)

    @property
    def cuts(self) -> dict[str, ca.SX]:
        """Caps that stand for any numbers with what `capped` says of them."""
        return {"brakes": self.bounds.braking, "largest": self.largest}

    @property
    def force(self) -> ca.SX:
        """What the guard lets through."""
        return clipped(self["asked"], self["y"], self.bounds, self.coming)

    @property
    def hi(self) -> ca.SX:
        """Largest safe force."""
        return ceiling(self["y"], self.bounds, self.coming)

    @property
    def lo(self) -> ca.SX:
        """Smallest safe force."""
        return floor(self["y"], self.bounds, self.coming)

    def sound(self, faster: float = 1) -> tuple[Relation, ...]:
        """Signs, M_min <= M_max, 2 nbar <= u1, alpha T <= 1: no word about dbar."""
        b = self.bounds
        positive = [above(item) for item in (b.u1, b.period, b.M_min, b.alpha, self["delay"])]
        not_negative = [at_least(item) for item in (b.dbar, b.nbar, b.brake, b.f_min, b.f_speed)]
        return (
            *positive, *not_negative, at_least(b.M_max, b.M_min), above(b.u1, b.f_speed),
            at_least(ca.SX(faster), b.alpha * b.period), at_least(b.u1, 2 * b.nbar),
        )  # fmt: skip

    def can_be_kept(self, pushed: float = 1) -> tuple[Relation, ...]:
        """The theorem's hypotheses; a factor above 1 relaxes the first."""
        b = self.bounds
        need = 2 * self.net * (1 + b.alpha * self["delay"])
        have = b.M_min * b.alpha * (b.u1 - b.f_speed)
        return (*self.sound(), at_least(pushed * have, need), at_least(b.brake, self.net))

    @property
    def capped(self) -> tuple[Relation, ...]:
        """What guard.delay.caps proves of the caps, but for their sum."""
        b = self.bounds
        return (
            at_least(b.braking), at_least(b.braking, self.net), at_least(self.largest, b.braking),
        )  # fmt: skip

    def shared(self, more: float = 1) -> Relation:
        """The caps' sum: both directions together keep what braking needs."""
        b = self.bounds
        late = self["delay"] * (self.largest + self.net) / b.M_min
        needed = ca.fmax(b.braking + self.net, 0) / (b.M_min * b.alpha)
        return at_least(b.u1 - b.f_speed, late + more * needed)

    def room(self, coming: InFlight, more: float = 1) -> Relation:
        """M_min alpha (u1 - f_speed - ahead - back) >= max(brakes + net, 0)."""
        b = self.bounds
        left = b.M_min * b.alpha * (more * (b.u1 - b.f_speed) - coming.ahead - coming.back)
        return at_least(left, ca.fmax(b.braking + self.net, 0))

    @property
    def moving(self) -> tuple[Relation, ...]:
        """ahead >= 0, back >= 0."""
        return at_least(self["ahead"]), at_least(self["back"])

    def arrives(self, way: int, more: ca.SX | float = 0) -> tuple[Relation, ...]:
        """f_speed <= arrived <= max(way v, f_speed) + what is under way (+ more)."""
        coming = self["ahead"] if way > 0 else self["back"]
        most = ca.fmax(way * self["v"], self["f_speed"]) + coming + more
        return at_least(most, self["arrived"]), at_least(self["arrived"], self["f_speed"])

    def not_empty(self, way: int) -> tuple[Relation, ...]:
        """lo <= hi, of which forwards nothing hangs: the clip to hi is the last."""
        return () if way > 0 else (at_least(self.hi, self.lo),)

    def then(self, way: int, more: ca.SX | float = 0) -> ca.SX:
        """Comparison bound t after the new command has started to act."""
        push = ca.fmax(way * self.force + self.net + more, 0)
        return self["arrived"] + self["t"] * push / self["mass"]


def both_ways(
    claim: Claims, id: str, given: str, premises: str = "", back: str = ""
) -> Callable[[Directed], Directed]:
    """Enter the function as the claim ``id`` about v, and as ``id``-back about -v.

    ``back``: what the second one assumes beside ``given``.
    """

    def enter(function: Directed) -> Directed:
        claim(id, given=given, premises=premises)(function)
        claim(f"{id}-back", given=given + back, premises=premises, wording=f"{id} for -v", way=-1)(
            function
        )
        return function

    return enter
