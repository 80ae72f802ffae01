"""Numbers of a scenario that are needed to read a finished run, with the guard's assumptions."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.orientation import PAPER

from .obstacles import Shape

Pair: TypeAlias = tuple[float, float]
Event: TypeAlias = tuple[float, int]
"""A time [s] and a velocity axis: 1 linear, 2 angular, 3 a wheel over the ground."""
_GRID = 1e-6
"""Times this close to a sample, in sample periods, count as that sample: 0.3/0.1 is not 3."""
PLANTS = ("ode", "mujoco")
"""The plane model, and the rigid body on tyres."""
COUNTED = ("M_min", "M_max", "dbar", "nbar", "alpha")
"""Numbers of Settings and Assumptions that a guard assumes."""
TIGHTER = "state a smaller guard.dbar or a larger guard.M_min if they are true"
"""Remedy where a guard holds back more than it must."""
ROUNDING = 1e-6
"""Share of the largest force that may be an error of integration and rounding."""


@dataclass(frozen=True, kw_only=True)
class CountedNumbers:
    """Numbers that a guard assumes or results in; None if they are not known.

    ``dbar``: bound of the disturbance that the scenario states or implies [N, N m]; ``void``:
    sentences on effects that no such bound covers; ``usable`` and ``asked``, with the guard on:
    largest steady speeds that it allows, and those of the reference [m/s, rad/s]; ``M_min``,
    ``M_max`` [kg, kg m2], ``nbar`` [m/s, rad/s] and ``alpha`` [1/s]: as in `Guard`.
    """

    dbar: Pair | None = None
    void: str = ""
    usable: Pair | None = None
    asked: Pair | None = None
    M_min: Pair | None = None
    M_max: Pair | None = None
    nbar: Pair | None = None
    alpha: float | None = None


@dataclass(frozen=True)
class Settings(CountedNumbers):
    """Clocks, limits and windows under which a run was made.

    ``control`` and ``plant``: control period and plant step [s]; ``duration`` [s], as requested;
    ``v_u1``: limits of |v1| [m/s] and |omega| [rad/s]; ``v_min`` and ``v_max``: the limits of v1
    and omega, by default those; ``split``: time that separates the ISE
    before from the ISE after [s]; ``rms_from``: start of the torque's RMS window [s];
    ``tolerance``: position error that counts as tracked [m], None where not known; ``plant_kind``:
    "ode", the plane model, "mujoco", a rigid body, or "fmu", a foreign plant, whose ``plant`` is
    the monitor's sampling time; ``arrival``: time at which the desired motion comes to rest for
    good [s], None if it never does; ``keep_out``: circles and polygons that a body of ``radius``
    [m] must not touch; ``frames``: how the columns state orientations, as in a scenario;
    ``robots``: the robot from each time [s] on, as "65 kg"; empty where it does not change. Raises
    ArgumentError if a number is not finite or not positive.
    """

    control: float
    plant: float
    duration: float
    v_u1: Pair
    split: float
    rms_from: float = 2.0
    tolerance: float | None = None
    plant_kind: str = "ode"
    arrival: float | None = None
    keep_out: tuple[Shape, ...] = ()
    radius: float | None = None
    frames: str = PAPER
    robots: tuple[tuple[float, str], ...] = ()
    v_min: Pair | None = None
    v_max: Pair | None = None

    def __post_init__(self) -> None:
        for name in ("control", "plant", "duration"):
            if not 0 < getattr(self, name) < math.inf:
                raise ArgumentError(_message(name, getattr(self, name), "finite and positive"))
        for name in ("split", "rms_from"):
            if not 0 <= getattr(self, name) < math.inf:
                raise ArgumentError(_message(name, getattr(self, name), "finite and not negative"))
        if not all(limit > 0 for limit in self.v_u1):
            raise ArgumentError(_message("v_u1", self.v_u1, "two positive limits"))
        if self.dbar is not None and not all(bound >= 0 for bound in self.dbar):
            raise ArgumentError(_message("dbar", self.dbar, "two bounds from 0 up"))

    @property
    def sides(self) -> tuple[Pair, Pair]:
        """Least and largest v1 [m/s], and omega [rad/s]."""
        (v, omega), low, high = self.v_u1, self.v_min, self.v_max
        least, most = low or (-v, -omega), high or (v, omega)
        return (least[0], most[0]), (least[1], most[1])

    @property
    def masses(self) -> tuple[Pair, Pair] | None:
        """Smallest and largest mass and inertia [kg, kg m2]; None if not known."""
        return None if self.M_min is None or self.M_max is None else (self.M_min, self.M_max)

    @property
    def samples(self) -> int:
        """Number of control samples of a run that lasts its whole duration."""
        return self.index(self.duration)

    def index(self, time: float) -> int:
        """The first sample k with k * control >= ``time`` [s], regardless of rounding errors."""
        return math.ceil(time / self.control - _GRID)


def _message(name: str, value: object, wanted: str) -> str:
    return f"settings.{name} = {value!r} must be {wanted}. Correct it where the run is built."


def stopping_force(mass: Pair, limit: Pair, period: float) -> Pair:
    """Force that stops the robot from the limit in one sample [N, N m]; numbers or symbols."""
    return mass[0] * limit[0] / period, mass[1] * limit[1] / period


def admitted(dbar: Pair, largest: Pair) -> Pair:
    """Largest d_least consistent with ``dbar``; arguments as in `Assumptions`."""
    return dbar[0] + ROUNDING * largest[0], dbar[1] + ROUNDING * largest[1]


@dataclass(frozen=True, kw_only=True)
class Assumptions(CountedNumbers):
    """A guard's assumptions on the motion; ``dbar`` is always known.

    ``force`` stops the robot in one sample [N, N m]: the scale of the monitor's comparison.
    """

    dbar: Pair
    force: Pair


def first_beyond(columns: Mapping[str, NDArray[np.float64]], bounds: Assumptions) -> Event | None:
    """Time [s] and axis of the first row whose d_least contradicts ``bounds``, or None."""
    if "d_least" not in columns:
        return None
    rows, axes = np.nonzero(columns["d_least"] > np.array(admitted(bounds.dbar, bounds.force)))
    return (float(columns["t"][rows[0]]), int(axes[0]) + 1) if rows.size else None


def largest_push(columns: Mapping[str, NDArray[np.float64]]) -> Pair | None:
    """Largest d_least of a log [N, N m]; None if no row has one, as for a foreign controller.

    Rows with NaN are skipped.
    """
    least = columns.get("d_least", np.empty((0, 2)))
    if np.isnan(least).all(axis=0).any():
        return None
    force, moment = np.fmax.reduce(least, axis=0).tolist()
    return force, moment
