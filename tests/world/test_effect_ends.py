"""Effects at the ends of what they admit, and what they tell the guard there."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from tests.papers_robot import paper
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.core.signals import MEASURED_VELOCITY, Signal
from wmr_ctrl.world.command_delay import COMMAND_DELAY
from wmr_ctrl.world.command_jerk import build as jerk
from wmr_ctrl.world.command_loss import COMMAND_LOSS
from wmr_ctrl.world.effect import Bound, total
from wmr_ctrl.world.grip import grip
from wmr_ctrl.world.model.system import NORMAL, System, draw, ports
from wmr_ctrl.world.push import build as push
from wmr_ctrl.world.references import Waypoints, sample
from wmr_ctrl.world.references.waypoints import waypoint_path
from wmr_ctrl.world.registry import EFFECTS
from wmr_ctrl.world.scenario import Scenario, override
from wmr_ctrl.world.velocity_loss import build as held
from wmr_ctrl.world.velocity_mean import VELOCITY_MEAN

T, H = 0.01, 0.001
BASE = {"base.kind": "velocity", "base.tau": [0.1, 0.1]}


def based(**changed: object) -> Scenario:
    return override(paper(), {**BASE, **changed})


def stepped(system: System, u, x) -> list[np.ndarray]:
    given = [u, x, system.p0, *([[1.0] * system.w.numel()] if system.draws else [])]
    step = system.function("step", [system.y, system.update])
    return [np.asarray(part).ravel() for part in step(*given)]


@pytest.mark.parametrize(("count", "possible"), [(500, True), (501, False)])
def test_five_hundred_commands_may_be_under_way(count: int, possible: bool) -> None:
    changed = {"base.delay": round(count * T, 9)}
    if possible:
        assert COMMAND_DELAY.bounded(based(**changed)).delay == pytest.approx(count * T)
    else:
        with pytest.raises(ScenarioError, match=r"base\.delay = 5\.01 s is 501 times"):
            based(**changed)


def test_a_jitter_of_a_whole_period_overtakes_nothing() -> None:
    assert override(paper(), {"actuator.jitter": T}).actuator.jitter == T
    with pytest.raises(ScenarioError, match="could otherwise overtake"):
        override(paper(), {"actuator.jitter": T + H})


@pytest.mark.parametrize(("limits", "most"), [((1.0, 3.0), 3.0), ((3.0, 1.0), 3.0)])
def test_a_jerk_limit_lets_the_rate_grow_to_the_larger_limit(limits, most) -> None:
    changed = {"base.accel": [limits[0]] * 2, "base.decel": [limits[1]] * 2}
    system = jerk(based(**changed))

    sent, after = stepped(system, [9.0, -9.0], [0.0, 0.0, 0.0, 0.0])

    assert after[2:] == pytest.approx([most, -most])
    assert sent == pytest.approx([most * H, -most * H])


@pytest.mark.parametrize(("losses", "timeout", "stops", "acts"), [
    (2, 0.029, True, True), (2, 0.03, False, True), (34, 0.35, False, True), (0, T, False, False),
    (0, 0.009, True, True), (0, 1.0, False, False),
])  # fmt: skip
def test_a_base_stops_between_commands_where_its_time_out_is_shorter(
    losses, timeout, stops, acts
) -> None:
    scenario = based(**{"base.losses": losses, "base.timeout": timeout})

    assert bool(COMMAND_LOSS.bounded(scenario).hidden) is stops
    assert COMMAND_LOSS.active(scenario) is acts


def test_less_than_one_count_is_nearest_to_one() -> None:
    with pytest.raises(ScenarioError, match=r"The nearest is 1\."):
        override(paper(), {"encoder.counts": 0.4})


def test_what_tyres_keep_is_the_least_of_all_phases() -> None:
    changes = [{"t": 1.0, "m": 20.0, "mu": 0.02}, {"t": 2.0, "m": 80.0, "mu": 0.2}]
    scenario = override(paper(), {"changes": changes})
    alone = [
        grip(override(paper(), {f"robot.{name}": change[name] for name in ("m", "mu")})).keep
        for change in changes
    ]

    assert grip(scenario).keep == pytest.approx(min(grip(paper()).keep, *alone))
    assert min(alone) < 0.9 * grip(paper()).keep
    assert grip(scenario).spin == grip(paper()).spin


@pytest.mark.parametrize("axis", [0, 1])
def test_two_means_of_one_axis_are_none_and_of_two_axes_are_two(axis: int) -> None:
    own, other = [0.0, 0.0], [0.0, 0.0]
    own[axis] = other[1 - axis] = 0.02
    one, two = Bound(window=tuple(own)), Bound(window=tuple(other))

    assert "window: two sensors average" in total([one, one]).void
    assert total([one, two]).void == ""
    assert total([one, two]).window == (0.02, 0.02)


def test_only_commands_and_drives_are_under_way() -> None:
    mean = next(item for item in EFFECTS if item.name == VELOCITY_MEAN.name)
    late = replace(
        mean, build=lambda scenario: replace(mean.build(scenario), transport=ca.SX(0.01))
    )

    with pytest.raises(ArgumentError, match="has a transport"):
        late.system(paper())


@pytest.mark.parametrize("old", [0, 1, 3])
def test_an_age_is_told_from_the_first_velocity_on_that_is_no_older_than_the_start(old) -> None:
    system = held(based(**{"sensor.velocity_age": old * T}))
    names = [item.signal.name for item in system.outputs]
    at = sum(item.signal.size for item in system.outputs[: names.index("odometry_age")])

    ages = [stepped(system, [0.3, 0.1, k], [0.0, 0.0, 0.0])[0][at] for k in range(6)]

    assert ages == pytest.approx([-1.0] * old + [old * T] * (6 - old))


def test_a_mean_is_off_by_the_rounding_of_the_way_and_what_is_late_by_nothing() -> None:
    """2^-53 of u1 times the duration in each step, and as much for the difference."""
    scenario = override(paper(), {"sensor.velocity_window": 0.02, "sensor.velocity_age": 0.01})
    late = override(paper(), {"sensor.velocity_age": 0.01})
    share = 2 * 2.0**-53 * scenario.clock.duration / H

    assert VELOCITY_MEAN.bounded(scenario).nbar == pytest.approx((share * 1.0, share * 1.5))
    assert VELOCITY_MEAN.bounded(late).nbar == (0.0, 0.0)


def test_random_numbers_come_in_pairs() -> None:
    wanted = ca.SX(1)

    assert draw(Signal("two", "1", "a pair", 2), NORMAL, wanted).port.signal.size == 2
    for size in (1, 3):
        with pytest.raises(ValueError, match=f"come in pairs, not {size}"):
            draw(Signal("odd", "1", "no pair", size), NORMAL, wanted)
    assert len(ports(MEASURED_VELOCITY)) == 2


@pytest.mark.parametrize("key", ["lag", "delay", "unmodelled_delay", "jitter"])
def test_drives_are_ideal_only_where_nothing_of_them_is_late(key: str) -> None:
    assert paper().actuator.ideal
    assert not override(paper(), {f"actuator.{key}": 0.01}).actuator.ideal


def test_at_rest_the_adversary_pushes_forward() -> None:
    system = push(override(paper(), {"disturbance.push": [8.0, 2.0]}))
    for v, omega, force in ((0.0, 0.0, (8.0, 2.0)), (-0.1, 0.0, (-8.0, 2.0)), (0.2, -1, (8, -2))):
        right, left = stepped(system, [v, omega], [])[0]
        assert ((right + left) / 0.1, 0.25 * (right - left) / 0.1) == pytest.approx(force)


def way(**changed: object) -> Waypoints:
    return override(paper(), {"reference.kind": "waypoints", **changed}).reference


def test_of_many_points_half_of_the_tolerance_is_for_those_left_out() -> None:
    """A corner of 250 points either way is cut by the other half."""
    side = np.linspace(0.0, 2.0, 250)
    points = [*([x, 0.0] for x in side), *([2.0, y] for y in side[1:])]
    few, many = (
        waypoint_path(way(**{"reference.points": own, "reference.tolerance": 0.2}))
        for own in ([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]], points)
    )

    cut = [
        float(np.hypot(*(path.derivatives(0, np.linspace(0, 1, 401)) - [2.0, 0.0]).T).min())
        for path in (few, many)
    ]
    assert cut == pytest.approx([0.2, 0.1], rel=0.02)


def test_a_closed_path_may_name_its_first_point_once_more() -> None:
    square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]
    closed = {"reference.closed": True, "reference.tolerance": 0.3}
    once, twice = (
        waypoint_path(way(**{"reference.points": own, **closed}))
        for own in (square, [*square, square[0]])
    )

    assert np.array_equal(once.coefficients, twice.coefficients)


@pytest.mark.parametrize("speed", [0.21, 0.37, 0.53])
def test_where_it_stops_it_never_drives_back(speed: float) -> None:
    scenario = override(paper(), {
        "reference.kind": "waypoints", "reference.speed": speed, "reference.tolerance": 0.1,
        "reference.points": [[0.0, 0.0], [1.0, 0.3], [1.7, 1.9]], "clock.duration": 40.0,
    })  # fmt: skip
    end = scenario.reference.arrival
    times = np.unique(np.append(end - np.geomspace(1e-15, 1e-3, 400), end))

    v = sample(scenario, times)[:, 3]
    assert (v >= 0).all()
    assert v[-1] == 0.0
