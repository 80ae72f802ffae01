"""Numbers that a setup's graphs do not depend on, and their ranges."""

import pytest

from tests.papers_robot import paper
from wmr_ctrl.control.numbers import SMALLEST, clock_of, fields_of, ranges_of, structure_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import LARGEST
from wmr_ctrl.world.scenario import override


def form(law="mb", **changed):
    return structure_of(settle(override(paper(), changed), law))


@pytest.mark.parametrize(
    "key, value, same",
    [
        ("robot.m", 60.0, True),
        ("disturbance.std", 0.5, True),
        ("gains.mb.rho", [3.0, 4.0], True),
        ("gains.mb.decay", "exact", False),
        ("gust.size", [1.0, 0.0], False),
        ("actuator.lag", 0.02, False),
        ("guard.enabled", True, False),
        ("reference.kind", "line", False),
    ],
)
def test_scenarios_of_one_form_differ_in_numbers_alone(key, value, same):
    assert (form(**{key: value}) == form()) is same
    assert form() != form("pid")


def test_ranges_are_those_of_the_fields_open_ends_told_apart():
    keys = ("robot.m", "gains.mb.rho", "slope.direction", "no.such", "gains.none.x")

    found = ranges_of(paper(), keys)
    assert found["gains.mb.rho"] == (SMALLEST, LARGEST)
    assert found["slope.direction"] == (-LARGEST, LARGEST)
    assert (
        set(fields_of(paper(), keys))
        == set(found)
        == {"robot.m", "gains.mb.rho", "slope.direction"}
    )


def test_the_clock_is_fixed_where_a_controller_counts_its_steps():
    late = override(paper(), {"actuator.delay": 0.02})

    assert clock_of(paper()) == {}
    assert clock_of(late) == {"clock.control": (0.01, 0.01), "clock.plant": (0.001, 0.001)}
