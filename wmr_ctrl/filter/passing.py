"""Sizes within which a command passes the filter unchanged, whatever came before it.

The clip's own limits; a governor's are never less, since the speed that it counts on is at most V
(ledger: corridor.governor).
"""

from __future__ import annotations

import casadi as ca

from wmr_ctrl.filter.clip import Clip
from wmr_ctrl.filter.filter import check_filter
from wmr_ctrl.filter.governor import largest_command
from wmr_ctrl.filter.governor_step import Governor
from wmr_ctrl.model.system import stack, values
from wmr_ctrl.scenario import Scenario

SHRUNK = 1 - 1e-12
"""Share of a limit that passes, roundings of the filter's own sums included."""
SIDES = ("v", "omega", "the right wheel", "the left wheel")


def passing_commands(scenario: Scenario) -> list[tuple[str, tuple[float, float], float]]:
    """Speeds row[0] v + row[1] omega by name, with the size within which a command passes.

    Of a clip without slew or a governor; empty without filter.  0 where none passes.
    """
    if scenario.filter.kind == "none":
        return []
    check_filter(scenario)
    built = Clip(scenario) if scenario.filter.kind == "clip" else Governor(scenario)
    limits = [largest_command(item.bounds.V, item.bounds) for item in built.channels]
    rows = ca.vertcat(*(ca.horzcat(*map(ca.SX, item.row)) for item in built.channels))
    ports = built.p.ports
    numbers = [stack(item.sym for item in ports)]
    graph = ca.Function("passing", numbers, [ca.vertcat(*limits), rows, built.sound])
    most, sides, sound = (item.full() for item in graph(values(ports)))
    most = most * sound
    names = SIDES[2:] if scenario.filter.channels == "wheels" else SIDES
    return [
        (name, (float(row[0]), float(row[1])), float(size[0]) * SHRUNK)
        for name, row, size in zip(names, sides, most, strict=False)
    ]
