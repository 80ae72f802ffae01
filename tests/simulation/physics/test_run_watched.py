"""Records of a run on a body: largest and least of all samples, and the first of events."""

from types import SimpleNamespace

import pytest

from tests.papers_robot import paper
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.results import RigidMonitor
from wmr_ctrl.simulation.physics.rigid import description
from wmr_ctrl.simulation.physics.run import Coupling, watched
from wmr_ctrl.world.scenario import override

H = 0.001


def coupled(*rows):
    """The coupling of a body whose slips, wheel speeds, tilt and tip margin are rows by step."""
    coupling, left, limits = object.__new__(Coupling), [*rows], paper().body
    now = SimpleNamespace(plane_state=(0.0,) * 7)
    body = SimpleNamespace(now=now)

    def step(_acting):
        now.slip, now.wheels, now.tilt, body.tip_margin = left.pop(0)

    body.step = step
    step(())
    loop = SimpleNamespace(
        sampled=lambda state: [0.0], acting=lambda held: (), ends=lambda state, reached: False
    )
    vars(coupling).update(
        body=body, loop=loop, limits=limits, clock=SimpleNamespace(substeps=1, plant=H),
        _changes={}, _row=1, _reached=0, seen=watched(RigidMonitor(), now, limits, 0.0),
        ended=False,
    )  # fmt: skip
    while left and not coupling.ended:
        coupling.sample()
    return coupling


def test_extremes_of_both_wheels_and_first_events_are_kept():
    seen = coupled(
        ((0.0, 0.0), (1.0, 1.0), 0.1, 0.9), ((0.05, -0.2), (2.0, -9.0), 0.4, 0.8),
        ((0.3, 0.0), (4.0, 1.0), 0.2, 0.2), ((0.0, 0.4), (1.0, 1.0), 0.0, 0.95),
    ).seen  # fmt: skip

    assert (seen.max_slip, seen.max_wheel_speed, seen.max_tilt) == (0.4, 9.0, 0.4)
    assert seen.least_tip_margin == 0.2
    assert (seen.slipped, seen.tipped) == (pytest.approx(H), None)


def test_it_ends_where_the_robot_has_tipped():
    still = (0.0, 0.0), (0.0, 0.0)
    coupling = coupled(*((*still, tilt, 1.0) for tilt in (0.0, 0.5, 0.51, 0.0, 0.0)))

    assert coupling.ended
    assert (coupling.seen.tipped, coupling._reached) == (pytest.approx(2 * H), 2)


def test_tyres_need_steps_of_five_milliseconds_at_most():
    description(override(paper(), {"clock.plant": 0.005}))
    with pytest.raises(ScenarioError, match=r"clock\.plant = 0\.01 s is too long for tyres"):
        description(override(paper(), {"clock.plant": 0.01}))
