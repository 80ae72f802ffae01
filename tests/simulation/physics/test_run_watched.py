"""What a run takes note of on a body: largest and least of all samples, and the first of events."""

from types import SimpleNamespace

import pytest

from tests.papers_robot import paper
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.simulation.physics.rigid import description
from wmr_ctrl.simulation.physics.run import Coupling
from wmr_ctrl.world.scenario import override

H = 0.001


class Body:
    """A body that is what a list says, one entry a plant step."""

    def __init__(self, slips, wheels, tilts, margins):
        self._k, self._rows = 0, list(zip(slips, wheels, tilts, margins, strict=True))
        self.plane_state = (0.0,) * 7

    def step(self, acting):
        self._k += 1

    def __getattr__(self, name):
        slip, wheels, tilt, margin = self._rows[self._k]
        return {"slip": slip, "wheels": wheels, "tilt": tilt, "tip_margin": margin}[name]


def watched(slips, wheels, tilts, margins):
    coupling = object.__new__(Coupling)
    coupling.body, coupling.scenario = Body(slips, wheels, tilts, margins), paper()
    coupling.clock = SimpleNamespace(substeps=1, plant=H)
    coupling.loop = SimpleNamespace(
        sampled=lambda state: [0.0], acting=lambda held: (), ends=lambda state, reached: False
    )
    vars(coupling).update(
        _changes={}, _row=1, _reached=0, _slip=0.0, _wheel=0.0, _tilt=0.0, _slipped=None,
        _tipped=None, _margin=1.0,
    )  # fmt: skip
    coupling.ended = coupling._watched()
    while coupling._reached < len(slips) - 1 and not coupling.ended:
        coupling.sample()
    return coupling


def test_extremes_of_both_wheels_and_first_events_are_kept():
    slips = [(0.0, 0.0), (0.05, -0.2), (0.3, 0.0), (0.0, 0.0), (0.0, 0.4)]
    wheels = [(1.0, 1.0), (2.0, -9.0), (4.0, 1.0), (1.0, 1.0), (1.0, 1.0)]
    tilts, margins = [0.1, 0.4, 0.2, 0.0, 0.0], [0.9, 0.8, 0.2, 0.7, 0.95]

    seen = watched(slips, wheels, tilts, margins).seen

    assert (seen.max_slip, seen.max_wheel_speed, seen.max_tilt) == (0.4, 9.0, 0.4)
    assert seen.least_tip_margin == 0.2
    assert (seen.slipped, seen.tipped) == (pytest.approx(H), None)


def test_it_ends_where_the_robot_has_tipped():
    still = [(0.0, 0.0)] * 5
    coupling = watched(still, still, [0.0, 0.5, 0.51, 0.0, 0.0], [1.0] * 5)

    assert coupling.ended
    assert (coupling.seen.tipped, coupling._reached) == (pytest.approx(2 * H), 2)


def test_tyres_need_steps_of_five_milliseconds_at_most():
    description(override(paper(), {"clock.plant": 0.005}))
    with pytest.raises(ScenarioError, match=r"clock\.plant = 0\.01 s is too long for tyres"):
        description(override(paper(), {"clock.plant": 0.01}))
