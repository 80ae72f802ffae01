"""Law: a control law as a value, with the traits that checks and reports need."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from wmr_ctrl.core.fields.section import Section, quantity
from wmr_ctrl.world.model.system import System

if TYPE_CHECKING:
    import casadi as ca

    from .context import LawContext

BARRIERS = ("paper", "smooth")
"""Forms of the barrier function: the paper's, and the one whose slope is continuous."""


@dataclass(frozen=True, kw_only=True)
class Traits:
    """Properties of a law, as its author states them.

    ``auxiliary``: Eq. (7) is its outer loop. ``barrier``: it evaluates the barrier function.
    ``model``: it assumes a mass and a friction. ``theorem``: the paper's theorem about it, 0 for
    none. ``estimates``: its memory has an estimate that is learnt during the run, so statements
    about the start may be wrong later. ``integrates``: these estimates never decay, so behind a
    command filter they are frozen while it sends something else. ``observer``: its memory holds a
    disturbance observer, which is linear and part of every linear statement about the loop.
    """

    auxiliary: bool = False
    barrier: bool = False
    model: bool = False
    theorem: int = 0
    estimates: bool = False
    integrates: bool = False
    observer: bool = False


@dataclass(frozen=True)
class Inside:
    """A law's System away from all its limits, and the conditions for that.

    ``within``: for each name an expression (2,) in the System's symbols and its largest size (2,)
    on either axis for which the law equals this System.  ``from_measured`` names the conditions
    that a first sample evaluates from the measured velocity, and later ones from the law's memory.
    """

    system: System
    within: Mapping[str, tuple[ca.SX, ca.SX]]
    from_measured: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Basis:
    """A robot on its base and path: the numbers from which unstated gains are derived.

    ``k`` [1/s, 1/m2, 1/s], ``rho`` [1/s] and ``wo`` [1/s] are those of `prox.guide`; ``speed`` of
    the path [m/s]; believed ``mass`` [kg, kg m2]; ``weight`` times the wheels' radius [N m];
    ``limits`` of the speeds and the largest rate ``accel`` of commands [m/s2, rad/s2].
    """

    k: tuple[float, float, float]
    rho: tuple[float, float]
    wo: float
    speed: float
    mass: tuple[float, float]
    weight: float
    limits: tuple[float, float]
    accel: tuple[float, float]

    @property
    def rate(self) -> tuple[float, float]:
        """Decay rate of a velocity loop [1/s], half of that of the squared error."""
        return self.rho[0] / 2, self.rho[1] / 2

    @property
    def damping(self) -> tuple[float, float]:
        """Force over velocity with that rate [N s/m, N m s/rad]."""
        return self.rate[0] * self.mass[0], self.rate[1] * self.mass[1]


def no_rule(_: Basis) -> Mapping[str, object]:
    """Default rule: no gain depends on the basis."""
    return {}


@dataclass(frozen=True)
class Law:
    """A control law: name, gains, graph, traits and its file's docstring.

    ``build(context)`` gives its System, whose output is the generalised force (N, N m).  ``tuned``
    names the gains that a search may change, all positive.  ``command(context)``, if given, is the
    law for a base that takes velocities, whose output is the velocity `ASKED`; other laws drive
    such a base through an adapter (`control/velocity.py`).  ``inside(context)`` is the law away
    from its limits, for laws that have a corridor.  ``rule(basis)`` gives the gains that depend on
    the robot, if a scenario does not state them.
    """

    name: str
    gains: type[Section]
    build: Callable[[LawContext], System]
    traits: Traits
    doc: str | None
    tuned: tuple[str, ...] = ()
    command: Callable[[LawContext], System] | None = None
    inside: Callable[[LawContext], Inside] | None = None
    rule: Callable[[Basis], Mapping[str, object]] = no_rule

    @property
    def title(self) -> str:
        """First line of its file's docstring, or its name."""
        return ((self.doc or "").strip().splitlines() or [self.name])[0].rstrip(".")


class TorqueLimited(Section, key="gains"):
    """Gains of a law with a torque limit of its own; the smaller limit is used."""

    tau_max: float = quantity(
        20.0, "N.m", "the law's own torque limit, in addition to actuator.tau_max", above=0.0
    )


class OwnKinematics(Section, key="gains"):
    """Gains of a law that may have its own gains of Eq. (7), in place of the shared ones."""

    kinematics: tuple[float, float, float] | None = quantity(
        None,
        "1/s, 1/m2, 1/s",
        "k_1, k_2, k_3 of Eq. (7) for this law alone; left out: gains.kinematics.k",
        size=3,
        above=0.0,
    )


class BarrierChoice(Section, key="gains"):
    """Gains of a law with a choice of the barrier function's form."""

    barrier: str = quantity("paper", "1", "form of the barrier f", options=BARRIERS)


class Predicting(Section, key="gains"):
    """Gains of a law that predicts the time when its command acts (see `prediction`)."""

    delay: float = quantity(
        0.0,
        "s",
        "delay over which the law predicts, at most that of the drives; 0: no prediction",
        minimum=0.0,
        maximum=10.0,
    )


def commands_predicted(gains: Section, period: float) -> int:
    """Number of commands in transit during the gains' delay, for a control period [s]."""
    return math.ceil(gains.delay / period - WHOLE) if isinstance(gains, Predicting) else 0


WHOLE = 1e-9
"""Share of a period that is no command more."""
