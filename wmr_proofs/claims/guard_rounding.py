"""The guard's rounding: the exact plant, pushed by the torques that the compiled text computes.

A computed number is any result of rounding each operation by at most 2^-53 (2^-24 in floats;
`wmr_proofs.statement.rounded`).  From |v| <= u1 to |v| <= u1: the guard's force, the map onto the
wheels, the conversion to torques and the motion.  `guard.rounding` composes them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from casadi import SX, fmax, vertcat

from wmr_ctrl.codegen.single_precision import MARGIN
from wmr_ctrl.control.guard.bounds import rounding
from wmr_ctrl.control.guard.guard import MAPS, Bounds, clipped, floor
from wmr_ctrl.world.model.dynamics import force_to_wheel, wheel_to_force
from wmr_proofs.claim import Claims, Mutation
from wmr_proofs.statement import (
    UNIT,
    Cuts,
    Number,
    Relations,
    Statement,
    Symbols,
    positive,
    symbols,
)

from .common import WAYS
from .guard_axis import GuardAxis


@dataclass(frozen=True)
class Precision:
    """Doubles or floats: the unit of rounding, and the reserved share of u1.

    ``spare``: share of M_min alpha u1, or of u1, by which the guard's conditions hold; ``quicker``:
    by how much alpha T may exceed 1, as the default 1/T is a rounded number.
    """

    unit: float
    kept: float

    @property
    def spare(self) -> float:
        """4 times the reserved share."""
        return 4 * self.kept

    @property
    def quicker(self) -> float:
        """8 units."""
        return 8 * self.unit


DOUBLE = Precision(UNIT, rounding(0))
SINGLE = Precision(2.0**-24, MARGIN)
ON_WHEELS = 18
"""Units of rounding of |F| + |N|/l: 12 of the map, 5 of the conversion, 1 for their product."""


@dataclass(eq=False)
class RoundedAxis(GuardAxis):
    """One axis of the guard whose formula is computed in doubles: ``hat`` is the computed force.

    ``widest`` is the largest G/(M_min alpha u1), G of both axes: the promise's range.

    ``held_back`` is the reserved margin, as a share of u1, and ``aimed`` are the bounds in the
    text, with u1 less that margin; ``slope`` is M_min alpha, ``reach`` K = M_min alpha u1 [N or N
    m], which stops the robot from its limit in 1/alpha; ``on_wheels`` is the largest loss of this
    axis' force by the wheels' rounding.
    """

    precision: Precision = DOUBLE
    widest: int = 24

    def __post_init__(self) -> None:
        super().__post_init__()
        self.held_back: Number = self.precision.kept
        self.aimed = replace(self.bounds, u1=self.u1 * (1 - self.held_back))
        self.slope = self.M_min * self.alpha
        self.reach = self.slope * self.u1
        self.on_wheels = ON_WHEELS * self.widest * self.precision.unit * self.reach

    def text(self, asked: SX, b: Bounds | None = None) -> Cuts:
        """Clipped force, as computed."""
        return {"hat": clipped(asked, self.y, b or self.aimed, self.coming)}

    @property
    def measured(self) -> Relations:
        """|y - v| <= nbar + unit |v|: the measured velocity is a rounded number, too."""
        gap, most = self.y - self.v, self.nbar + self.precision.unit * abs(self.v)
        return most >= gap, most >= -gap

    @property
    def stated(self) -> Relations:
        """The theorem's hypotheses with room for the rounding."""
        b, spare = self.bounds, self.precision.spare * self.reach
        less = b.u1 * (1 - self.precision.spare)
        return (
            self.signs, b.M_max >= b.M_min,
            1 + self.precision.quicker >= b.alpha * b.period,
            self.slope * (b.u1 - b.f_speed) >= 2 * self.net + spare,
            less >= 2 * b.nbar, less >= b.f_speed,
            b.brake >= self.net + spare / 2, self.reach >= -self.net,
        )  # fmt: skip

    def safe(self, way: int, force: SX) -> Relations:
        """Hypothesis: the force leaves the margin that the wheels' rounding and the motion need."""
        fastest = self.arrived if self.lateness else fmax(way * self.v, self.f_speed)
        left = self.slope * (self.u1 * (1 - self.held_back / 32) - fastest)
        return fmax(left, 0) >= way * force + self.net + self.on_wheels


def _wheels() -> Symbols:
    names = " ".join(f"{name}{i}" for name in ("force", "safe", "cap", "size", "lo", "hi")
                     for i in (1, 2))  # fmt: skip
    return symbols(f"{names} thrust moment right left phi half r", "phi half r")


def _within(most: SX, value: SX) -> Relations:
    return most >= value, most >= -value


PRECISIONS = {"double": {"precision": DOUBLE}, "single": {"precision": SINGLE}}
PARTS = " ".join(
    f"guard.rounding.{part}" for part in ("force", "size", "anchor", "maps", "torques")
)
claim = Claims(premises="assumption.libm")


def in_each(parts: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """These parts of an entry in each precision."""
    return {
        f"{name}-{key}": {**part, **row}
        for name, row in PRECISIONS.items()
        for key, part in parts.items()
    }


@claim("guard.rounding.force", each=in_each(WAYS))
def force(mutation: Mutation, way: int, precision: Precision) -> Statement:
    """the computed force F^ has F^ + net + 432 unit K <= max(M_min alpha (u1 (1 - kept/32) -
    max(v, f_speed)), 0), and the same of -F^ and -v.

    The computed force keeps the limit ahead and back, with room for the rounding of the wheels'
    torques; the braking branch is included.

    Given: {ROUNDING_STATED}; |v| <= u1, |y - v| <= nbar + unit |v|; back, lo(y) = -hi(-y) is what
    this says ahead.
    """
    # Ahead, whatever lo is: hi is clipped to last.  Back, lo being what hi is ahead, mirrored.
    a = RoundedAxis(precision=precision)
    b = mutation(a.aimed, a.bounds)
    known = () if way > 0 else (a.safe(way, a["lo"]),)
    given = a.stated, a.measured, a.inside, known
    goal = a.safe(way, a.hat)
    computed = a.text(a.asked, b)
    return Statement(a, goal, given, {"lo": floor(a.y, b)}, computed=computed, unit=precision.unit)


@claim("guard.rounding.size", each=PRECISIONS)
def size(mutation: Mutation, precision: Precision) -> Statement:
    """|F^| <= (K + max(-net, 0)) (1 + 8 unit).

    No computed force is large enough to make its rounding matter.

    Given: {ROUNDING_STATED}.
    """
    # Of what may be asked, and of the safe point.
    a = RoundedAxis(precision=precision)
    most = (a.reach + fmax(-a.net, 0)) * (1 + mutation(a.precision.quicker, -0.01))
    goals = most >= a.hat, most >= -a.hat
    return Statement(a, goals, a.stated, computed=a.text(a.asked), unit=precision.unit)


@claim("guard.rounding.anchor", each=PRECISIONS)
def anchor(mutation: Mutation, precision: Precision) -> Statement:
    """the computed safe point is at most the computed min(brake, cap).

    The computed force keeps the reserve that the wheels need.

    Given: {ROUNDING_STATED}.
    """
    a = RoundedAxis(precision=precision)
    most = mutation(1, 0.99) * a.most
    goals = most >= a.hat, most >= -a.hat
    computed = {**a.text(SX(0)), "most": a.aimed.braking}
    return Statement(a, goals, a.stated, computed=computed, unit=precision.unit)


@claim("guard.rounding.maps", each=in_each({kind: {"kind": kind} for kind in MAPS}))
def mapped(mutation: Mutation, kind: str, precision: Precision) -> Statement:
    """each map as computed ends between the asked force and the safe point, to 12 unit (G1 + G2/l)
    in N, l times that in N m.

    The rounding of the torque limit does not undo the guard.

    Given: any phi and l > 0; |F_i| <= G_i, |safe_i| <= cap_i <= G_i, cap1 + cap2/l <= phi (1 +
    4 unit); {PRECISION}.
    """
    t = _wheels()
    given: list[Relations] = [positive(t.half, t.phi)]
    for i in "12":
        given += _within(t[f"cap{i}"], t[f"safe{i}"]), _within(t[f"size{i}"], t[f"force{i}"])
        given.append(t[f"size{i}"] >= t[f"cap{i}"])
        for value in (t[f"force{i}"], t[f"safe{i}"]):
            given += t[f"hi{i}"] >= value, value >= t[f"lo{i}"]
    given.append(t.phi * (1 + 4 * precision.unit) >= t.cap1 + t.cap2 / t.half)
    lost = mutation(12, 1) * precision.unit * (t.size1 + t.size2 / t.half)
    goals = list[Relations]()
    for i, value, error in (("1", t.thrust, lost), ("2", t.moment, lost * t.half)):
        goals += t[f"hi{i}"] + error >= value, value >= t[f"lo{i}"] - error
    force, safe = (vertcat(t[f"{part}1"], t[f"{part}2"]) for part in ("force", "safe"))
    both = MAPS[kind](force, t.phi, t.half, safe)
    computed = {"thrust": both[0], "moment": both[1]}
    return Statement(t, goals, given, computed=computed, unit=precision.unit)


@claim("guard.rounding.torques", each=PRECISIONS)
def converted(mutation: Mutation, precision: Precision) -> Statement:
    """the exact force of the computed torques differs from the force that was converted by at most
    5 unit (|F| + |N|/l), the moment by l times that.

    The plant is pushed by torques, which are rounded numbers as well.

    Given: any force, r, l > 0; r and l are the plant's; {PRECISION}.
    """
    t = _wheels()
    half, asked = t.half, vertcat(t.force1, t.force2)
    torque = force_to_wheel(t.r, half, asked)
    reached = wheel_to_force(t.r, half, vertcat(t.right, t.left))
    lost = mutation(5, 2) * precision.unit * (abs(asked[0]) + abs(asked[1]) / half)
    goals = _within(lost, reached[0] - asked[0]), _within(lost * half, reached[1] - asked[1])
    computed = {"right": torque[0], "left": torque[1]}
    return Statement(t, goals, positive(half, t.r), computed=computed, unit=precision.unit)


@claim("guard.rounding", premises=f"{PARTS} guard.axes guard.lemma", each=PRECISIONS)
def together(mutation: Mutation, precision: Precision) -> Statement:
    """max(v, f_speed) + t max(F + net, 0)/M <= u1 for all t in [0, T], F the exact force of the
    torques that the compiled text computes: from |v| <= u1 to |v| <= u1, and the same for -v.

    The limit itself is kept for a sample by the exact robot behind the double-precision guard, to
    the last bit: torque conversion, box, clip and braking branch are in it. A package in single
    precision keeps it, too, since its limit is lowered by 2^-15. With f_min <= dbar and T and alpha
    of both axes alike, l M_min1 u1_1/(M_min2 u1_2) in [1/22, 22] is enough: I/(m l^2) from 1/22 to
    22 times u1_1/(l u1_2).

    Given: {ROUNDING_STATED}; both axes; G1 + G2/l <= 24 K1, l G1 + G2 <= 24 K2, G = (K + max(-net,
    0)) (1 + 8 unit); min(brake1, cap1) + min(brake2, cap2)/l <= (2 tau_max/r) (1 + 4 unit); no
    overflow, no underflow; in single precision no fused multiply-add, and numbers as the package
    holds them, its v_u1 being u1 (1 - 2^-15) to 2^-24.
    """
    # ``hat``: the exact force of the torques; ``asked`` and ``most``: the forces it is between.
    a = RoundedAxis(precision=precision)
    b, lost = a.bounds, mutation(1, 2) * a.on_wheels
    goals, given = [], [a.stated, a.inside, a.during()]
    for way in (1, -1):
        end = fmax(way * a.v, b.f_speed) + a.t * fmax(way * a.hat + a.net, 0) / a.mass
        goals.append(b.u1 >= end)
        given.append(fmax(way * a.asked, way * a.most) + lost >= way * a.hat)
        given += [a.safe(way, a[name]) for name in ("asked", "most")]
    return Statement(a, goals, given)
