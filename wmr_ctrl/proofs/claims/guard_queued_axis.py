"""Symbols and hypotheses of the guard's claims behind a delay in rounded arithmetic."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca

from wmr_ctrl.guard.delay import InFlight
from wmr_ctrl.guard.guard import Bounds
from wmr_ctrl.proofs.claims.guard_axis import NUMBERS, PRESENT, GuardAxis
from wmr_ctrl.proofs.claims.guard_rounding import DOUBLE, ON_WHEELS
from wmr_ctrl.proofs.statement import UNIT, Relation, above, at_least, symbols

SPREAD = 16
"""Largest (G1 + G2/l)/K1 max(1, alpha delay), and the same for the second axis: the range."""
WHEELS = ON_WHEELS * SPREAD
READ = 5 * SPREAD
"""Units of K that the wheels' rounding takes, and that reading a command back from torques does."""
FAR = 15 / 32
"""Share of ``kept`` by which both sums together may be more than the caps allow."""
LATE = "delay ahead back arrived brakes largest more hat most lo"


@dataclass(frozen=True)
class QueuedAxis(GuardAxis):
    """One axis; ``arrived`` bounds v (or -v) where the new command starts to act."""

    @cached_property
    def symbols(self) -> dict[str, ca.SX]:
        """Every number by name; ``share`` is what is left of u1."""
        return symbols(f"{NUMBERS} {PRESENT} {LATE} share", f"{NUMBERS} delay share")

    @cached_property
    def bounds(self) -> Bounds:
        """The stated numbers, with the delay."""
        at_once = Bounds(**{name: self[name] for name in NUMBERS.split()})
        return replace(at_once, delay=self["delay"])

    @cached_property
    def aimed(self) -> Bounds:
        """What the text reads: u1 is shrunk."""
        return replace(self.bounds, u1=self["u1"] * self["share"])

    @property
    def kept(self) -> ca.SX:
        """What is kept back, as a share of u1."""
        return 1 - self["share"]

    @property
    def coming(self) -> InFlight:
        """What is under way, as its two sums."""
        return InFlight(self["ahead"], self["back"])

    @property
    def late(self) -> ca.SX:
        """alpha delay."""
        return self["alpha"] * self["delay"]

    @property
    def reach(self) -> ca.SX:
        """K = M_min alpha u1 [N or N m]."""
        return self["M_min"] * self["alpha"] * self["u1"]

    @property
    def slope(self) -> ca.SX:
        """M_min alpha."""
        return self["M_min"] * self["alpha"]

    @property
    def stated(self) -> tuple[Relation, ...]:
        """The theorem's hypotheses with room for the rounding, but for those of the caps."""
        b, less = self.bounds, self["u1"] * (1 - 4 * self.kept)
        positive = [above(item) for item in (b.u1, b.period, b.M_min, b.alpha, self["delay"])]
        counted = (b.dbar, b.nbar, b.f_min, b.f_speed, self["ahead"], self["back"])
        not_negative = [at_least(item) for item in counted]
        return (
            *positive, *not_negative, at_least(b.M_max, b.M_min),
            at_least(1 + DOUBLE.quicker, b.alpha * b.period),
            at_least(self.kept, 1024 * UNIT), at_least(2.0**-20, self.kept),
            at_least(less, 2 * b.nbar), at_least(less, b.f_speed),
            at_least(self.reach, self.net), at_least(self.reach, -self.net),
        )  # fmt: skip

    @property
    def enough(self) -> Relation:
        """kept = (1 + n) 2^-44 with alpha delay <= n, n commands."""
        return at_least(self.kept * (1 + 2.0**-40), 512 * UNIT * (1 + self.late))

    @property
    def met(self) -> tuple[Relation, ...]:
        """The conditions of the caps."""
        room = self.kept * self.reach
        need = (1 + self.late) * (2 * ca.fmax(self.net, 0) + 8 * room)
        have = self.slope * (self["u1"] - self["f_speed"])
        brakes = at_least(self["brake"], ca.fabs(self.net) + 5 * room)
        return (at_least(have, need), brakes, at_least(self.late, 2.0**-6), self.enough)

    @property
    def aim(self) -> ca.SX:
        """M_min alpha (u1 (1 - kept) - f_speed)."""
        return self.slope * (self["u1"] * self["share"] - self["f_speed"])

    def capped(self, brakes: ca.SX, largest: ca.SX) -> tuple[Relation, ...]:
        """What brakes and the largest command leave to each other."""
        room = 2 * self.kept * self.reach
        return (
            at_least(brakes), at_least(brakes, ca.fabs(self.net) + room), at_least(largest),
            at_least(largest, self.net + room),
        )  # fmt: skip

    @property
    def over(self) -> ca.SX:
        """By how much the computed brakes' part of the sum may be off, times 1 + alpha delay."""
        return (16 + 8 * (1 + self.late)) * UNIT * self.reach

    def arrives(self, way: int) -> tuple[Relation, ...]:
        """arrived <= max(way v, f_speed) + what was computed to be under way, and <= u1."""
        coming = self["ahead"] if way > 0 else self["back"]
        fastest = ca.fmax(way * self["v"], self["f_speed"])
        most = fastest + coming * (1 + self.kept / 64) + self["u1"] * self.kept / 8
        return at_least(most, self["arrived"]), at_least(self["u1"], self["arrived"])

    def safe(self, way: int, force: ca.SX) -> Relation:
        """The force leaves what the wheels' rounding and the motion need."""
        left = self.slope * (self["u1"] * (1 - self.kept / 32) - self["arrived"])
        return at_least(ca.fmax(left, 0), way * force + self.net + self.on_wheels)

    @property
    def on_wheels(self) -> ca.SX:
        """What the wheels' rounding may take of this axis."""
        return WHEELS * UNIT * self.reach

    def room(self, brakes: ca.SX) -> Relation:
        """What both sums leave for braking."""
        u1 = self["u1"] * (1 - self.kept * (1 - FAR))
        left = self.slope * (u1 - self["f_speed"] - self["ahead"] - self["back"])
        return at_least(left, ca.fmax(brakes + self.net, 0))
