"""The guard's rounding: the exact plant, pushed by the torques that the compiled text computes.

A computed number is here whatever rounding each operation by at most 2^-53 (2^-24 in floats) can
give (`wmr_ctrl.proofs.rounded`).  From |v| <= u1 to |v| <= u1: the guard's force, the map onto the
wheels, the conversion to torques and the motion, and `guard.rounding` puts them together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import log2

import casadi as ca

from wmr_ctrl.codegen.single_precision import MARGIN
from wmr_ctrl.guard.bounds import rounding
from wmr_ctrl.guard.guard import Bounds, clipped, floor
from wmr_ctrl.guard.wheel_map import MAPS
from wmr_ctrl.model.dynamics import force_to_wheel, wheel_to_force
from wmr_ctrl.proofs.claim import OURS, Claim
from wmr_ctrl.proofs.claims.guard_axis import NUMBERS, PRESENT, GuardAxis
from wmr_ctrl.proofs.methods.spec import Z3
from wmr_ctrl.proofs.rounded import UNIT
from wmr_ctrl.proofs.statement import Relation, Statement, above, at_least, symbols

THEME = "guard"


@dataclass(frozen=True)
class Precision:
    """Doubles or floats: the unit of rounding, the share of u1 kept back, what is left of that.

    ``left``: share of u1 for the motion's own inequality; ``spare``: share of M_min alpha u1, or of
    u1, by which the guard's conditions hold; ``quicker``: by how much alpha T may exceed 1.
    """

    unit: float
    kept: float

    @property
    def left(self) -> float:
        """1/32 of what is kept back."""
        return self.kept / 32

    @property
    def spare(self) -> float:
        """4 times what is kept back."""
        return 4 * self.kept

    @property
    def quicker(self) -> float:
        """8 units: the default 1/T is a rounded number."""
        return 8 * self.unit


DOUBLE = Precision(UNIT, rounding(0))
SINGLE = Precision(2.0**-24, MARGIN)
ON_WHEELS = 18
"""Units of rounding of |F| + |N|/l: 12 of the map, 5 of the conversion, 1 for their product."""
SPREAD = 24
"""Largest G/(M_min alpha u1), G of both axes: the promise's range."""


@dataclass(frozen=True)
class RoundedAxis(GuardAxis):
    """One axis of the guard whose formula is computed in doubles: ``hat`` is what comes out."""

    precision: Precision = DOUBLE

    @cached_property
    def symbols(self) -> dict[str, ca.SX]:
        """Every number by name."""
        return symbols(f"{NUMBERS} {PRESENT} hat most lo", NUMBERS)

    @cached_property
    def aimed(self) -> Bounds:
        """What the text reads: u1 is shrunk."""
        return replace(self.bounds, u1=self["u1"] * (1 - self.precision.kept))

    @property
    def reach(self) -> ca.SX:
        """K = M_min alpha u1 [N or N m]: what stops the robot from its limit in 1/alpha."""
        return self["M_min"] * self["alpha"] * self["u1"]

    @property
    def stated(self) -> tuple[Relation, ...]:
        """The theorem's hypotheses with room for the rounding."""
        b, spare = self.bounds, self.precision.spare * self.reach
        positive = [above(item) for item in (b.u1, b.period, b.M_min, b.alpha)]
        not_negative = [at_least(item) for item in (b.dbar, b.nbar, b.brake, b.f_min, b.f_speed)]
        slope, less = b.M_min * b.alpha, b.u1 * (1 - self.precision.spare)
        return (
            *positive, *not_negative, at_least(b.M_max, b.M_min),
            at_least(1 + self.precision.quicker, b.alpha * b.period),
            at_least(slope * (b.u1 - b.f_speed), 2 * self.net + spare),
            at_least(less, 2 * b.nbar), at_least(less, b.f_speed),
            at_least(b.brake, self.net + spare / 2), at_least(self.reach, -self.net),
        )  # fmt: skip

    def safe(self, way: int, force: ca.SX, wheels: ca.SX) -> Relation:
        """The force leaves what the wheels' rounding and the motion need."""
        b = self.bounds
        fastest = ca.fmax(way * self["v"], b.f_speed)
        left = b.M_min * b.alpha * (b.u1 * (1 - self.precision.left) - fastest)
        return at_least(ca.fmax(left, 0), way * force + self.net + wheels)

    @property
    def on_wheels(self) -> ca.SX:
        """What the wheels' rounding may take of this axis."""
        return ON_WHEELS * SPREAD * self.precision.unit * self.reach


def _force(way: int, precision: Precision, flip: float) -> Statement:
    """Ahead, whatever lo is: hi is clipped to last.  Back, lo being what hi is ahead, mirrored."""
    a = RoundedAxis(precision)
    b = a.aimed if flip > 0 else a.bounds
    cuts = {"lo": floor(a["y"], b)}
    known = () if way > 0 else (a.safe(way, a["lo"], a.on_wheels),)
    given = (*a.stated, *a.measured, *a.inside, *known)
    goal = a.safe(way, a["hat"], a.on_wheels)
    computed = {"hat": clipped(a["asked"], a["y"], b)}
    return Statement(a.symbols, (goal,), given, cuts, computed=computed, unit=precision.unit)


def _size(precision: Precision, flip: float) -> Statement:
    """Of what may be asked, and of the safe point."""
    a = RoundedAxis(precision)
    most = (a.reach + ca.fmax(-a.net, 0)) * (1 + (a.precision.quicker if flip > 0 else -0.01))
    goals = (at_least(most, a["hat"]), at_least(most, -a["hat"]))
    computed = {"hat": clipped(a["asked"], a["y"], a.aimed)}
    return Statement(a.symbols, goals, a.stated, computed=computed, unit=precision.unit)


def _anchor(precision: Precision, flip: float) -> Statement:
    a = RoundedAxis(precision)
    most = (1 if flip > 0 else 0.99) * a["most"]
    goals = (at_least(most, a["hat"]), at_least(most, -a["hat"]))
    computed = {"hat": clipped(ca.SX(0), a["y"], a.aimed), "most": a.aimed.braking}
    return Statement(a.symbols, goals, a.stated, computed=computed, unit=precision.unit)


def _wheels() -> dict[str, ca.SX]:
    names = " ".join(f"{name}{i}" for name in ("force", "safe", "cap", "size", "lo", "hi")
                     for i in (1, 2))  # fmt: skip
    return symbols(f"{names} thrust moment right left phi half r", "phi half r")


def _within(most: ca.SX, value: ca.SX) -> tuple[Relation, Relation]:
    return at_least(most, value), at_least(most, -value)


def _mapped(name: str, precision: Precision, flip: float) -> Statement:
    t = _wheels()
    found, given = (t["thrust"], t["moment"]), [above(t["half"]), above(t["phi"])]
    for i in "12":
        given += [*_within(t[f"cap{i}"], t[f"safe{i}"]), *_within(t[f"size{i}"], t[f"force{i}"])]
        given.append(at_least(t[f"size{i}"], t[f"cap{i}"]))
        for part in ("force", "safe"):
            given += [
                at_least(t[f"hi{i}"], t[f"{part}{i}"]),
                at_least(t[f"{part}{i}"], t[f"lo{i}"]),
            ]
    given.append(at_least(t["phi"] * (1 + 4 * precision.unit), t["cap1"] + t["cap2"] / t["half"]))
    lost = (12 if flip > 0 else 1) * precision.unit * (t["size1"] + t["size2"] / t["half"])
    goals = [part for i, error in ((1, lost), (2, lost * t["half"]))
             for part in (at_least(t[f"hi{i}"] + error, found[i - 1]),
                          at_least(found[i - 1], t[f"lo{i}"] - error))]  # fmt: skip
    force, safe = (ca.vertcat(t[f"{part}1"], t[f"{part}2"]) for part in ("force", "safe"))
    both = MAPS[name](force, t["phi"], t["half"], safe)
    computed = {"thrust": both[0], "moment": both[1]}
    return Statement(t, tuple(goals), tuple(given), computed=computed, unit=precision.unit)


def _converted(precision: Precision, flip: float) -> Statement:
    t = _wheels()
    half, asked = t["half"], ca.vertcat(t["force1"], t["force2"])
    torque = force_to_wheel(t["r"], half, asked)
    reached = wheel_to_force(t["r"], half, ca.vertcat(t["right"], t["left"]))
    lost = (5 if flip > 0 else 2) * precision.unit * (ca.fabs(asked[0]) + ca.fabs(asked[1]) / half)
    goals = (*_within(lost, reached[0] - asked[0]), *_within(lost * half, reached[1] - asked[1]))
    computed = {"right": torque[0], "left": torque[1]}
    return Statement(t, goals, (above(half), above(t["r"])), computed=computed, unit=precision.unit)


def _together(precision: Precision, flip: float) -> Statement:
    """``hat``: the exact force of the torques; ``asked`` and ``most``: the forces it is between."""
    a = RoundedAxis(precision)
    b, lost = a.bounds, (1 if flip > 0 else 2) * a.on_wheels
    goals, given = [], [*a.stated, *a.inside, *a.during]
    for way in (1, -1):
        fastest = ca.fmax(way * a["v"], b.f_speed)
        end = fastest + a["t"] * ca.fmax(way * a["hat"] + a.net, 0) / a["mass"]
        goals.append(at_least(b.u1, end))
        asked, safe = way * a["asked"], way * a["most"]
        given.append(at_least(ca.fmax(asked, safe) + lost, way * a["hat"]))
        given += [a.safe(way, a[name], a.on_wheels) for name in ("asked", "most")]
    return Statement(a.symbols, tuple(goals), tuple(given))


HARD = Z3(effort=100)


def _stated(precision: Precision) -> str:
    spare, quicker = _two(precision.spare), _two(precision.quicker)
    return (
        f"every u1, T, 0 < M_min <= M_max, dbar, nbar, alpha T <= 1 + {quicker}, brake, f_min, "
        f"f_speed with room for the rounding: 2 net + {spare} K <= M_min alpha (u1 - f_speed), "
        f"K = M_min alpha u1, -K <= net = dbar - f_min; brake >= net + {_two(precision.spare / 2)} "
        f"K; 2 nbar, f_speed <= u1 (1 - {spare})"
    )


def _two(power: float) -> str:
    return f"2^{int(log2(power))}"


def _claim(
    name: str,
    claim: str,
    meaning: str,
    hypotheses: str,
    statement: Callable[[float], Statement],
    premises: tuple[str, ...] = ("assumption.libm",),
) -> Claim:
    key = f"guard.{name}"
    return Claim(
        key, (), OURS, claim, meaning, hypotheses, statement, HARD, premises=premises, theme=THEME
    )


def _maps(precision: Precision, name: str, rounds: str) -> tuple[Claim, ...]:
    """Both maps onto the wheels."""
    unit = _two(precision.unit)
    return tuple(
        _claim(
            f"{name}.{kind}",
            f"{kind} as computed ends between the asked force and the safe point, to "
            f"12 {unit} (G1 + G2/l) in N, l times that in N m",
            "Nor does the torque limit's arithmetic undo the guard.",
            "any phi and l > 0; |F_i| <= G_i, |safe_i| <= cap_i <= G_i, cap1 + cap2/l <= phi "
            f"(1 + {_two(4 * precision.unit)}){rounds}",
            partial(_mapped, kind, precision),
        )
        for kind in MAPS
    )


def _parts(precision: Precision, name: str) -> tuple[Claim, ...]:
    """What the promise is put together from."""
    unit, quicker = _two(precision.unit), _two(precision.quicker)
    stated, rounds = _stated(precision), f"; operations rounded by at most {unit}"
    forces = (
        _claim(
            f"{name}.force-{word}",
            f"the computed force F^ has {sign}F^ + net + 432 {unit} K <= max(M_min alpha "
            f"(u1 (1 - {_two(precision.left)}) - max({sign}v, f_speed)), 0)",
            f"What the guard's text computes keeps the limit {word}, and leaves room for what the "
            "wheels' arithmetic adds; the branch that brakes is in it.",
            f"{stated}; |v| <= u1, |y - v| <= nbar{rounds}{known}",
            partial(_force, way, precision),
            ("assumption.libm", *premises),
        )
        for word, way, sign, known, premises in (
            ("ahead", 1, "", "", ()),
            (
                "back",
                -1,
                "-",
                f"; lo(y) = -hi(-y) by guard.{name}.force-ahead",
                (f"guard.{name}.force-ahead",),
            ),
        )
    )
    return (
        *forces,
        _claim(
            f"{name}.size",
            f"|F^| <= (K + max(-net, 0)) (1 + {quicker})",
            "No computed force is large enough to make its rounding matter.",
            stated + rounds,
            partial(_size, precision),
        ),
        _claim(
            f"{name}.anchor",
            "the computed safe point is at most the computed min(brake, cap)",
            "What the wheels have to keep free is what the text keeps free.",
            stated + rounds,
            partial(_anchor, precision),
        ),
        *_maps(precision, name, rounds),
        _claim(
            f"{name}.torques",
            "the exact force of the computed torques misses what was converted by at most "
            f"5 {unit} (|F| + |N|/l), the moment by l times that",
            "The plant is pushed by torques, which are rounded numbers as well.",
            "any force, r, l > 0; r and l are the plant's" + rounds,
            partial(_converted, precision),
        ),
    )


def _promised(precision: Precision, name: str, meaning: str, numbers: str) -> tuple[Claim, ...]:
    """The parts, and what they make together."""
    parts, quicker = _parts(precision, name), _two(precision.quicker)
    together = _claim(
        name,
        "max(v, f_speed) + t max(F + net, 0)/M <= u1 for all t in [0, T], F the exact force of the "
        "torques that the compiled text computes: from |v| <= u1 to |v| <= u1, and the same for -v",
        meaning,
        f"{_stated(precision)}; both axes; G1 + G2/l <= 24 K1, l G1 + G2 <= 24 K2, G = (K + "
        f"max(-net, 0)) (1 + {quicker}); min(brake1, cap1) + min(brake2, cap2)/l <= (2 tau_max/r) "
        f"(1 + {_two(4 * precision.unit)}); no overflow, no underflow{numbers}",
        partial(_together, precision),
        (*(part.id for part in parts), "guard.axes", "guard.lemma"),
    )
    return (*parts, together)


CLAIMS = (
    *_promised(
        DOUBLE,
        "rounding",
        "The limit itself is kept by the exact robot behind the double-precision guard, to the "
        "last bit and for ever: torque conversion, box, clip and braking branch are in it. "
        "With f_min <= dbar and T and alpha of both axes alike, l M_min1 u1_1/(M_min2 u1_2) in "
        "[1/22, 22] is enough: I/(m l^2) from 1/22 to 22 times u1_1/(l u1_2).",
        "",
    ),
    *_promised(
        SINGLE,
        "rounding.single",
        "A package in single precision keeps the limit, too, since its limit is lowered by 2^-15. "
        "Same range.",
        ", no fused multiply-add; numbers as the package holds them, its v_u1 being u1 (1 - 2^-15) "
        "to 2^-24",
    ),
)
