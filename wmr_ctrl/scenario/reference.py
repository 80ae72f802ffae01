"""The kinds of desired trajectory, each a frozen dataclass; theta_d is 0 along +Y.

All of them start at t = 0.  ``cycle`` is the time after which the desired velocities repeat
(inf if they never do).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.section import Section, quantity
from wmr_ctrl.scenario.initial import HEADING


@dataclass(frozen=True)
class Circle(Section):
    """Circle through the origin, as in Section V: x = R sin wt, y = R - R cos wt."""

    KEY: ClassVar[str] = "reference"

    radius: float = quantity(2.0, unit="m", doc="radius", minimum=1e-6)
    rate: float = quantity(0.1, unit="rad/s", doc="angular rate; negative: driven backwards")

    @property
    def cycle(self) -> float:
        """Period of the velocities, s: they are constant."""
        return math.inf


@dataclass(frozen=True)
class Line(Section):
    """Straight line at constant speed along (-sin heading, cos heading)."""

    KEY: ClassVar[str] = "reference"

    speed: float = quantity(0.2, unit="m/s", doc="speed")
    heading: float = quantity(HEADING, unit="rad", doc="orientation; -pi/2 is along +X")
    origin: tuple[float, float] = quantity((0.0, 0.0), unit="m", doc="x, y at t = 0")

    @property
    def cycle(self) -> float:
        """Period of the velocities, s: they are constant."""
        return math.inf


@dataclass(frozen=True)
class Lemniscate(Section):
    """Figure of eight (of Gerono): x = a sin wt, y = a sin wt cos wt."""

    KEY: ClassVar[str] = "reference"

    size: float = quantity(2.0, unit="m", doc="half the width; the height equals it", minimum=1e-6)
    rate: float = quantity(
        0.1, unit="rad/s", doc="rate of the phase; one lap is 2 pi/rate", minimum=1e-6
    )

    @property
    def cycle(self) -> float:
        """Time of one lap, s."""
        return 2 * math.pi / self.rate


@dataclass(frozen=True)
class RoundedSquare(Section):
    """Square with smoothed corners, counter-clockwise from the middle of its lower side."""

    KEY: ClassVar[str] = "reference"

    side: float = quantity(3.0, unit="m", doc="side of the square", minimum=1e-6)
    corner: float = quantity(
        0.8,
        unit="m",
        doc="length of side that a corner takes at each end; at most side/2",
        minimum=1e-6,
    )
    speed: float = quantity(0.2, unit="m/s", doc="speed, nearly constant", minimum=1e-6)

    def relate(self) -> None:
        """Two corners must fit on a side."""
        if self.corner > self.side / 2:
            raise ScenarioError(
                f"reference.corner = {self.corner!r} must be at most half of reference.side = "
                f"{self.side!r} m: two corners share a side. Lower corner or raise side."
            )

    @property
    def cycle(self) -> float:
        """Time of one lap, s."""
        from wmr_ctrl.scenario.paths import path_of

        return path_of(self).duration


@dataclass(frozen=True)
class StopAndGo(Section):
    """The circle with a speed that rises from 0 and falls to 0 again in every period."""

    KEY: ClassVar[str] = "reference"

    radius: float = quantity(2.0, unit="m", doc="radius", minimum=1e-6)
    speed: float = quantity(0.4, unit="m/s", doc="largest speed; the mean is half of it", above=0)
    period: float = quantity(10.0, unit="s", doc="time from one stop to the next", minimum=1e-6)

    @property
    def cycle(self) -> float:
        """Period of the velocities, s."""
        return self.period


@dataclass(frozen=True)
class Waypoints(Section):
    """Smooth path (four continuous derivatives) through given points at nearly constant speed.

    An open path is left straight on, along its last tangent, when its end is reached before the
    run's.  A closed path returns from the last point to the first and is repeated.
    """

    KEY: ClassVar[str] = "reference"

    points: tuple[tuple[float, float], ...] = quantity(
        (), unit="m", doc="x, y of each point, in the order of travel", kind="points"
    )
    speed: float = quantity(0.2, unit="m/s", doc="speed, nearly constant", minimum=1e-6)
    closed: bool = quantity(False, unit="", doc="whether the path returns to its first point")

    def relate(self) -> None:
        """The path must exist: enough points, none twice in a row, no turning on the spot."""
        from wmr_ctrl.scenario.paths import path_of

        path_of(self)

    @property
    def cycle(self) -> float:
        """Time of one lap, or of the open path, s."""
        from wmr_ctrl.scenario.paths import path_of

        return path_of(self).duration


Reference: TypeAlias = Circle | Line | Lemniscate | RoundedSquare | StopAndGo | Waypoints

KINDS: dict[str, type[Reference]] = {
    "circle": Circle,
    "line": Line,
    "lemniscate": Lemniscate,
    "rounded-square": RoundedSquare,
    "stop-and-go": StopAndGo,
    "waypoints": Waypoints,
}
"""Name of each kind, as the key ``reference.kind`` gives it."""


def kind_name(reference: Reference) -> str:
    """Return the name of a reference's kind."""
    return next(name for name, cls in KINDS.items() if type(reference) is cls)
