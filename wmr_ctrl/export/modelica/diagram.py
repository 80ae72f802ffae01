"""Positions of ports and parts in the Modelica package's diagrams, and lines between them.

Modelica's units: an icon is 200 wide and 200 high around 0, x to the right, y upwards. Ports are
just outside of an icon's edge; a part in a diagram is its icon at half the size.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

Point: TypeAlias = tuple[float, float]

EDGE, _WIDEST = 110.0, 40.0
"""Middle of a port beyond an edge, and its largest distance to the next."""
_SCALE = 0.5
"""Size of a part in a diagram beside its icon."""
_NEAREST, _GAP = 10.0, 8.0
"""Distance of a line around parts from the ports, and from the next line."""


@dataclass(frozen=True)
class Place:
    """Centre of a port in its icon, and its rotation in degrees."""

    x: float
    y: float
    turn: int = 0

    @property
    def placement(self) -> str:
        """Annotation of its declaration."""
        return _placed(10, self.x, self.y, f", rotation={self.turn}" if self.turn else "")


@dataclass(frozen=True)
class Site:
    """Centre of a part in a diagram."""

    x: float
    y: float

    @property
    def placement(self) -> str:
        """Annotation of its declaration."""
        return _placed(100 * _SCALE, self.x, self.y)

    def end(self, port: Place) -> Point:
        """Position of one of the part's ports in the diagram."""
        return self.x + _SCALE * port.x, self.y + _SCALE * port.y


LOOP = {
    "reference": Site(-160, 0),
    "controller": Site(0, 0),
    "plant": Site(160, 0),
    "disturbance": Site(160, 140),
}
"""Parts of the closed loop."""
CONNECTED = (
    ("reference", "controller"),
    ("controller", "plant"),
    ("disturbance", "plant"),
    ("plant", "controller"),
)
"""Parts that give and take; what the plant gives back runs around all parts."""
LOOP_EXTENT = "{{-230,-140},{280,210}}"
WITHIN = Site(0, 0)
"""The one part of a block around an FMU."""


@dataclass(frozen=True)
class Places:
    """Positions of a part's ports by name."""

    inputs: Mapping[str, Place]
    outputs: Mapping[str, Place]


@dataclass(frozen=True)
class Wire:
    """A connection between two ports, and the annotation that draws it."""

    start: str
    end: str
    line: str


def places_of_parts(*ports: Sequence[str]) -> dict[str, Places]:
    """Ports of each part of the loop; ports joined by a straight line are opposite each other.

    ``ports``: outputs of the reference; inputs and outputs of the law; those of the plant.
    """
    desired, asked, torques, given, motion = ports
    fed_back = [name for name in asked if name not in desired]
    pushes = [name for name in given if name not in torques]
    shown = _side(desired, -EDGE) | edge(fed_back, -EDGE, 90)
    driven = _side(torques, -EDGE) | edge(pushes, EDGE, -90)
    return {
        "reference": Places({}, _side(desired, EDGE)),
        "controller": Places(shown, _side(torques, EDGE)),
        "plant": Places(driven, _side(motion, EDGE)),
        "disturbance": Places({}, edge(pushes, -EDGE, -90)),
    }


def wires_of_loop(parts: Mapping[str, Places]) -> list[Wire]:
    """All connections of the loop."""
    wires = []
    for giver, taker in CONNECTED:
        given, taken = parts[giver].outputs, parts[taker].inputs
        names = [name for name in given if name in taken]
        ends = [(LOOP[giver].end(given[name]), LOOP[taker].end(taken[name])) for name in names]
        lines = _around(ends) if giver == "plant" else [_line(*pair) for pair in ends]
        wires += [
            Wire(f"{giver}.{name}", f"{taker}.{name}", drawn)
            for name, drawn in zip(names, lines, strict=True)
        ]
    return wires


def wires_within(ports: Places) -> list[Wire]:
    """Connections between the ports of a block and the equal ports of the FMU in it."""
    wires = [
        Wire(name, f"fmu.{name}", _line((port.x, port.y), WITHIN.end(port)))
        for name, port in ports.inputs.items()
    ]
    return wires + [
        Wire(f"fmu.{name}", name, _line(WITHIN.end(port), (port.x, port.y)))
        for name, port in ports.outputs.items()
    ]


def _side(names: Sequence[str], x: float) -> dict[str, Place]:
    """Ports on a left or right edge, from the top."""
    return {name: Place(x, -y) for name, y in zip(names, _spread(len(names), 90.0), strict=True)}


def edge(names: Sequence[str], y: float, turn: int) -> dict[str, Place]:
    """Ports on an upper or lower edge, from the left."""
    places = (Place(x, y, turn) for x in _spread(len(names), 80.0))
    return dict(zip(names, places, strict=True))


def _line(*points: Point) -> str:
    return f"Line(points={{{','.join(map(_pair, points))}}}, color={{0,0,127}})"


def _around(ends: Sequence[tuple[Point, Point]]) -> list[str]:
    """Lines from ports on a right edge, below everything, up to ports on a lower edge.

    Lines from upper ports to the left are outermost, so that none crosses another.
    """
    lowest = min(min(start[1], end[1]) for start, end in ends)
    lines = []
    for k, (start, end) in enumerate(reversed(ends)):
        beside, below = start[0] + _NEAREST + _GAP * k, lowest - 2 * _NEAREST - _GAP * k
        lines.append(_line(start, (beside, start[1]), (beside, below), (end[0], below), end))
    return lines[::-1]


def _spread(count: int, reach: float) -> list[float]:
    """Evenly spaced positions from -reach to reach, closer together for a few."""
    step = min(_WIDEST, 2 * reach / max(count - 1, 1))
    return [step * (k - (count - 1) / 2) for k in range(count)]


def _placed(half: float, x: float, y: float, more: str = "") -> str:
    extent = f"{{{_pair((-half, -half))},{_pair((half, half))}}}"
    return f"Placement(transformation(extent={extent}, origin={_pair((x, y))}{more}))"


def _pair(point: Point) -> str:
    x, y = (round(number, 3) + 0.0 for number in point)
    return f"{{{x:g},{y:g}}}"
