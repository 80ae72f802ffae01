"""The package as a drawing: read from its text, as a tool with diagrams would."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import combinations, pairwise, product

import numpy as np
import pytest

from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.export.modelica.diagram import edge, places_of_parts, wires_of_loop

NUMBER = r"-?\d+(?:\.\d+)?"
PAIR = rf"\{{({NUMBER}),({NUMBER})\}}"
PLACED = (
    rf"Placement\(transformation\(extent=\{{{PAIR},{PAIR}\}},"
    rf"\s*origin={PAIR}(?:,\s*rotation=({NUMBER}))?"
)
PARTS = ("reference", "controller", "plant", "disturbance")
LEADS_IN = {(-1, 0): 0.0, (1, 0): 180.0, (0, 1): -90.0, (0, -1): 90.0}
"""Rotation [deg] of an input port, by the edge of its part."""


@dataclass(frozen=True)
class Drawn:
    """A placed port or part: half its size, its centre and its rotation."""

    kind: str
    half: float
    middle: np.ndarray
    turn: float = 0.0

    def at(self, port):
        """Middle of a port of this part, in the diagram."""
        return self.middle + self.half / 100 * port.middle


def classes(text, kind, name):
    return re.search(
        rf"^( *)(?:partial )?{kind} {name}\s.*?^\1end {name};", text, flags=re.S | re.M
    )[0]


def placed(body, declared):
    """Declarations of a kind by name, each with its placement."""
    found = {}
    for start in re.finditer(rf"^ *{declared}", body, flags=re.M):
        statement = body[start.start() :].partition(";\n")[0]
        drawn = re.search(PLACED, statement)
        assert drawn, statement
        numbers = [float(number or 0) for number in drawn.groups()]
        assert numbers[:2] == [-numbers[2], -numbers[3]]
        found[start[2]] = Drawn(start[1], numbers[2], np.array(numbers[4:6]), numbers[6])
    return found


def ports(text, part):
    """Ports of a part's interface, by name."""
    body = classes(text.partition("end Interfaces;")[0], "block", part.capitalize())
    found = placed(body, r"(RealInput|RealOutput) (\w+)")
    return {name: port for name, port in found.items() if port.half == 10}


def lines(body):
    pattern = rf"connect\(([\w.]+), ([\w.]+)\)\s*annotation\(Line\(points=\{{((?:{PAIR},?)+)\}}"
    return {
        (match[1], match[2]): np.array(re.findall(PAIR, match[3]), float)
        for match in re.finditer(pattern, body)
    }


def crosses(one, other):
    """True if two polylines of horizontal and vertical segments share a point."""
    boxes = (
        [(np.min(p, axis=0), np.max(p, axis=0)) for p in pairwise(each)] for each in (one, other)
    )
    return any(
        (low <= other_high).all() and (other_low <= high).all()
        for (low, high), (other_low, other_high) in product(*boxes)
    )


def assert_apart(*drawn):
    """No two ports or parts cover each other."""
    for one, other in combinations(drawn, 2):
        assert np.abs(one.middle - other.middle).max() > one.half + other.half


@pytest.mark.parametrize("law", LAWS)
def test_what_a_law_shows_stands_beside_its_inputs_and_torques(text, law):
    body = classes(text, "block", law.capitalize())
    own = placed(body, r"Interfaces\.(RealInput|RealOutput) (\w+)").values()
    assert len(own) == body.count("Interfaces.Real") >= 5
    assert {(port.middle[1], port.turn) for port in own} == {(110, LEADS_IN[0, 1] + 180)}
    assert_apart(*own, *ports(text, "controller").values())


@pytest.mark.parametrize("model", ["Loop", "Loop_imported"])
def test_the_loop_is_a_diagram(text, model):
    """Parts stand apart, lines run from port to port, none through a part or another line."""
    body = classes(text, "model", model)
    parts = placed(body, rf"(?:replaceable )?([\w.]+) ({'|'.join(PARTS)}) ")
    drawn = lines(body)
    assert tuple(parts) == PARTS
    assert_apart(*parts.values())
    assert len(drawn) == body.count("connect(") == 7 + 2 + 4 + 5
    square = np.array([[-1, -1], [-1, 1], [1, 1], [1, -1], [-1, -1]])
    frames = [part.middle + part.half * square for part in parts.values()]
    for ends, points in drawn.items():
        for end, point in zip(ends, (points[0], points[-1]), strict=True):
            part, name = end.split(".")
            assert np.allclose(parts[part].at(ports(text, part)[name]), point)
        assert (np.diff(points, axis=0) == 0).any(axis=1).all()
        assert not any(crosses(points, frame) for frame in frames)
    assert not any(crosses(one, other) for one, other in combinations(drawn.values(), 2))
    corners = re.search(rf"coordinateSystem\(extent=\{{{PAIR},{PAIR}\}}", body).groups()
    low, high = np.array(corners, float).reshape(2, 2)
    everything = np.vstack([*drawn.values(), *frames])
    assert ((low < everything) & (everything < high)).all()


@pytest.mark.parametrize("part", PARTS[:3])
def test_a_block_around_an_fmu_is_a_diagram(text, part):
    """Lines run from each port of the block to the FMU's port of that name."""
    body, outer = classes(text, "block", f"{part.capitalize()}Fmu"), ports(text, part)
    fmu = placed(body, r"(Fmu) (fmu)")["fmu"]
    drawn = lines(body)
    assert len(drawn) == body.count("connect(") == len(outer)
    for ends, points in drawn.items():
        for end, point in zip(ends, points, strict=True):
            within, _, name = end.rpartition(".")
            assert np.allclose(fmu.at(outer[name]) if within else outer[name].middle, point)


def test_ports_are_spread_over_an_edge_and_wires_join_equal_names():
    assert [place.x for place in edge(["a", "b", "c"], -100, 90).values()][1] == 0
    parts = places_of_parts(["d"], ["d", "v"], ["tau"], ["tau", "push"], ["v"])

    wires = {(wire.start, wire.end) for wire in wires_of_loop(parts)}
    assert wires == {
        ("reference.d", "controller.d"), ("controller.tau", "plant.tau"),
        ("disturbance.push", "plant.push"), ("plant.v", "controller.v"),
    }  # fmt: skip
