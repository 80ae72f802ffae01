"""Symbols and hypotheses that the guard's claims share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from wmr_ctrl.guard.guard import Bounds, clipped
from wmr_ctrl.proofs.statement import Relation, above, at_least, symbols

NUMBERS = "u1 period M_min M_max dbar nbar alpha brake f_min f_speed"
PRESENT = "v y asked mass t"


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
