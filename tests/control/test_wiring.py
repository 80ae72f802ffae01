"""Systems joined by the names of their signals."""

import casadi as ca
import pytest

from tests.papers_robot import paper
from tests.tables import changes
from wmr_ctrl.control.setup import settle
from wmr_ctrl.control.wiring import FIRST_STREAM, Stream, Wiring
from wmr_ctrl.core.signals import PLANT_STATE, TORQUE_NOISE, Signal
from wmr_ctrl.world.effect import EffectRole, Rate
from wmr_ctrl.world.model.system import NORMAL, UNIFORM, Parameters, draw
from wmr_ctrl.world.scenario import override


def wiring(**changed):
    setup = settle(override(paper(), changed), "mb")
    true = {item.name: ca.SX.sym(item.name) for item in PLANT_STATE}
    return Wiring(setup, Parameters(setup.scenario), Rate.SAMPLE, true)


def test_a_system_adds_its_state_and_draws_and_shows_its_outputs():
    joined = wiring(**changes("disturbance.std = 0.5; gust.size = [1.0, 0.5]"))
    shown = [joined.run(system) for system in joined.effects(EffectRole.DISTURBANCE)]

    names = {name for item in shown for name in item}
    assert {item.name for item in TORQUE_NOISE} | {"thrust", "moment"} <= names
    assert [item.signal.name for item in joined.state] == ["gust_share"]
    assert {item.name for item in joined.streams} == {"torque", "gust"}


def test_a_streams_number_depends_on_its_name_alone():
    said = ca.SX(2, 1)
    sample, step = Rate.SAMPLE, Rate.STEP
    chosen = (("torque", NORMAL, sample), ("mine", UNIFORM, step), ("mine", NORMAL, sample))
    streams = [
        Stream(draw(Signal(name, "1", "numbers", 2), kind, ca.SX(1)), rate, said)
        for name, kind, rate in chosen
    ]

    assert streams[0].number == 0
    assert streams[1].number == streams[2].number >= FIRST_STREAM
    assert [item.normal for item in streams] == [True, False, True]


def test_time_is_that_of_the_sample():
    joined = wiring()
    period = joined.parameters.take("clock.control")
    time = ca.Function("t", [joined.clock.sym, period], [joined.known["t"]])

    assert float(time(7, 0.01)) == pytest.approx(0.07)
