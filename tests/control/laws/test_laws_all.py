"""Requirements that every control law must satisfy."""

import tomllib

import numpy as np
import pytest

from wmr_ctrl.control.controller import controller, law_graph
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.setup import gains_of, settle
from wmr_ctrl.core.errors import ScenarioError, UnknownNameError
from wmr_ctrl.core.signals import DIAGNOSTICS, FORCE, POSE, REFERENCE, TAU_APPLIED, VELOCITY
from wmr_ctrl.world.scenario import load_scenario, override

SCENARIO = load_scenario("paper-simulation-nominal")
NOMINAL = (0.0, 0.0, -np.pi / 2, 0.2, 0.1, 0.0, 0.0)
every_law = pytest.mark.parametrize("law", tuple(LAWS))


def sample(system, u, x=None):
    """Next state, outputs and diagnostics for inputs u; no torque was applied before."""
    f = system.function("sample", [system.update, system.y, system.d])
    given = np.zeros(system.u.numel())
    given[: len(u)] = u
    return tuple(item.full().ravel() for item in f(given, system.x0 if x is None else x, system.p0))


def inputs(draw):
    """Reference, pose up to metres away from it, velocity inside the limits."""
    reference = np.array(NOMINAL) + draw.normal(size=7) * (1, 1, 3, 0, 0, 0, 0)
    pose = reference[:3] + draw.normal(size=3) * 10 ** draw.uniform(-3, 0.7)
    return np.concatenate([reference, pose, draw.uniform(-0.99, 0.99, 2) * (1.0, 1.5)])


@every_law
@pytest.mark.slow_but("pid", "mb", "kanayama")
def test_ports_are_the_common_ones(law):
    system = law_graph(settle(SCENARIO, law))

    common, further = [*REFERENCE, *POSE, *VELOCITY], [item.signal for item in system.inputs][12:]
    assert [item.signal for item in system.inputs][:12] == common
    assert further in ([], [TAU_APPLIED])
    assert [item.signal for item in controller(settle(SCENARIO, law)).inputs] == common
    assert [item.signal for item in system.outputs] == [FORCE]
    assert tuple(item.signal for item in system.diagnostics[: len(DIAGNOSTICS)]) == DIAGNOSTICS
    assert system.period == SCENARIO.clock.control


@every_law
def test_parameters_are_named_once_by_their_scenario_key(law):
    params = controller(settle(SCENARIO, law)).params
    names = [item.signal.name for item in params]

    assert len(names) == len(set(names))
    roots = {name.split(".")[0] for name in names}
    assert roots <= {"robot", "model", "limits", "gains", "clock", "actuator", "guard"}
    assert all(item.signal.unit and item.signal.meaning for item in params)


@every_law
@pytest.mark.slow_but("mb", "nn", "prox")
def test_a_whole_turn_of_the_heading_changes_nothing(law):
    system, draw = law_graph(settle(SCENARIO, law)), np.random.default_rng(2)
    for way in (1, -1):
        u = inputs(draw)
        turned = u + way * 2 * np.pi * (np.arange(12) == 9)
        assert sample(system, turned)[1] == pytest.approx(sample(system, u)[1], rel=1e-6, abs=1e-6)


@every_law
@pytest.mark.slow_but("pid", "nn")
def test_torque_limit_is_never_exceeded(law):
    limited = override(SCENARIO, {"actuator.tau_max": 6.5})
    system, draw = controller(settle(limited, law)), np.random.default_rng(3)
    for _ in range(200):
        assert abs(sample(system, inputs(draw))[1]).max() <= 6.5 * (1 + 1e-15)


STATED = tomllib.loads("""
    pid = {Kp = [210.0, 1.1], Kd = [0.64, 0.08]}
    smc = {K = [200.0, 20.0], eta = [5.0, 0.5], boundary = 0.1, v_s = 0.01, g_m = 0.5, g_F = 50.0}
    kanayama = {k = [4.0, 64.0, 16.0], rate = [20.0, 10.0], wo = 5.0, share = 0.95, a_max = [2, 6]}
    pursuit = {lookahead = 1.5, distance = [0.3, 0.9], radius = 0.9, slowest = 0.25, turn = 1.8}
""")


@pytest.mark.parametrize("law", STATED)
def test_gains_of_laws_that_are_compared_are_the_stated_ones(law):
    gains = gains_of(load_scenario("paper-simulation-no-switch"), LAWS[law])
    for name, value in STATED[law].items():
        assert np.array_equal(getattr(gains, name), value), name


@every_law
def test_gains_are_checked(law):
    name = next(iter(vars(gains_of(SCENARIO, LAWS[law]))))

    with pytest.raises(ScenarioError, match=rf"gains\.{law}\.{name}"):
        gains_of(override(SCENARIO, {f"gains.{law}.{name}": "high"}), LAWS[law])
    with pytest.raises((UnknownNameError, ScenarioError), match="gain_of_none"):
        gains_of(override(SCENARIO, {f"gains.{law}.gain_of_none": 1.0}), LAWS[law])


@every_law
def test_documentation_names_source_and_differences(law):
    doc = LAWS[law].doc

    assert "Source:" in doc
    assert "Differences from the paper:" in doc
    assert "Choose it" in doc


def test_feedforward_is_not_dropped_at_the_target():
    """At v = v_c0 exactly, MB requests M1 v_c0' + F1; with the printed A^-1 := 0 it would request
    F1 alone.
    """
    system = law_graph(settle(SCENARIO, "mb"))
    accelerating = (0.0, 0.0, 0.0, 0.2, 0.1, 0.7, -0.4)
    u = (*accelerating, 0.0, 0.0, 0.0, 0.2, 0.1)
    friction = 0.08 * 50.0 * 9.81 * np.tanh(0.2 / 0.01)

    assert sample(system, u)[1] == pytest.approx([50.0 * 0.7 + friction, 5.4 * -0.4], rel=1e-12)
