"""What is different about a law in single precision: the guard's margin, and where it was tried."""

from __future__ import annotations

from dataclasses import replace

from wmr_ctrl.model.system import Port, System

MARGIN = 2.0**-15
"""The guard's limits are lowered by this share of theirs: 512 times the rounding of a float, as
the graph's own margin is 512 times that of a double."""

LARGEST_SINGLE = 1e6
"""What no input may exceed in size, where double precision has `signals.LARGEST`."""

LIMIT = "limits.v_u1"

PERIODS = {
    ("mb", False): (1e-3,),
    ("nn", False): (1e-3, 1e-2),
    ("prox", False): (1e-3, 1e-2),
    ("mb", True): (1e-3, 1e-2),
    ("nn", True): (1e-3, 1e-2),
    ("prox", True): (1e-3, 1e-2),
}
"""Control periods [s] at which a law, guarded or not, kept the limit in simulation wherever double
precision did; the tests of the boards repeat it."""


def with_margin(system: System) -> System:
    """The same law with its limits' values lowered by MARGIN."""
    return replace(system, params=tuple(_lowered(item) for item in system.params))


def _lowered(item: Port) -> Port:
    if item.signal.name != LIMIT:
        return item
    return replace(item, value=tuple(number * (1 - MARGIN) for number in item.value))
