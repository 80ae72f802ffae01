"""A monitor behind every law: it changes no torque, and what it publishes is what it says."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from tests import oracle
from tests.codegen.compiled import compiled
from tests.oracle.guard import VelocityGuard
from wmr_ctrl.api import compile_law, simulate
from wmr_ctrl.codegen.emit import Kernel, kernel
from wmr_ctrl.control.controller import controller, law_graph, watched_controller
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.signals import GUARD_DIAGNOSTICS, POSE, REFERENCE, VELOCITY
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.scenario import Scenario, load_scenario, override

every_law = pytest.mark.parametrize("law", tuple(LAWS))
every_twin = pytest.mark.parametrize("law", NAMES)
DRIVES: dict[str, dict[str, Any]] = {
    "ideal": {},
    "limited": {"actuator.tau_max": 6.5},
    "slow": {"actuator.lag": 0.02, "actuator.delay": 0.004},
}
SHORT = {"clock.duration": 3.0, "changes": [{"t": 1.0, "m": 65.0, "I": 7.0, "mu": 0.15}]}


def scenario_of(drive: str = "ideal", **changed: Any) -> Scenario:
    return load_scenario("paper-simulation", {**SHORT, **DRIVES[drive], **changed})


def stepped(system: System, name: str, results: ca.SX) -> Kernel:
    """Next state, then ``results``, as one vector."""
    known = {"u": system.u, "x": system.x, "p": system.p}
    return kernel(name, "One sample.", known, {"w": ca.vertcat(system.update, results)})


def diagnostics(system: System) -> tuple[list[Any], list[Any]]:
    """Signals, and values at the start."""
    at_start = system.function("d", [system.d])(np.zeros(system.u.numel()), system.x0, system.p0)
    return [item.signal for item in system.diagnostics], at_start.full().ravel().tolist()


@pytest.mark.parametrize(("law", "drive"), [("prox", "limited"), ("nn", "slow")])
@pytest.mark.slow
def test_generated_c_gives_the_same_torques_to_the_bit(law: str, drive: str) -> None:
    """Over samples in a row, with and without the diagnostics computed beside them."""
    scenario = scenario_of(drive)
    plain, watched = controller(settle(scenario, law)), watched_controller(settle(scenario, law))
    both = ca.vertcat(watched.y, watched.d)
    steps = compiled([stepped(plain, "plain", plain.y), stepped(watched, "short", watched.y),
                      stepped(watched, "whole", both)])  # fmt: skip
    systems, draw = (plain, watched, watched), np.random.default_rng(0)
    states = [np.array(system.x0) for system in systems]
    for _ in range(100):
        u = draw.normal(size=12) * (1, 1, 3, 0.2, 0.1, 0.1, 0.1, 1, 1, 3, 0.4, 0.6)
        given = zip(steps, states, systems, strict=True)
        found = [step(u, x, system.p0) for step, x, system in given]
        counts = [system.x.numel() for system in systems]
        states = [row[:n] for row, n in zip(found, counts, strict=True)]
        torques = [row[n : n + 2].tolist() for row, n in zip(found, counts, strict=True)]
        assert torques[0] == torques[1] == torques[2]
        own = law_graph(settle(scenario, law)).x.numel()
        assert states[0][:own].tolist() == states[1][:own].tolist()


@every_law
@pytest.mark.slow_but("mb")
def test_the_unwatched_law_repeats_a_native_run_to_the_bit(law: str) -> None:
    scenario = scenario_of("limited")
    system, run = controller(settle(scenario, law)), simulate(scenario, law, seed=3)
    (step,) = compiled([stepped(system, "plain", system.y)], native=True)
    inputs = np.column_stack([run[s.name] for s in (*REFERENCE, *POSE, *VELOCITY)])
    x = np.array(system.x0)
    for u, right, left in zip(inputs, run["tau_right"], run["tau_left"], strict=True):
        found = step(u, x, system.p0)
        x = found[: x.size]
        assert found[x.size :].tolist() == [right, left]


@every_twin
@pytest.mark.slow_but("mb", "nn")
def test_twins_do_not_feel_the_monitor(law: str, monkeypatch: pytest.MonkeyPatch) -> None:
    watched = oracle.simulate(scenario_of(), law, seed=3)
    monkeypatch.setattr(VelocityGuard, "watch", lambda *_: None)
    blind = oracle.simulate(scenario_of(), law, seed=3)

    assert watched["d_least"].any()
    assert not blind["d_least"].any()
    for name in ("tau_right", "tau_left", "v1", "omega"):
        assert np.array_equal(watched[name], blind[name])


@every_law
@pytest.mark.slow_but("mb", "prox")
def test_a_guarded_controller_is_watched_anyway(law: str) -> None:
    scenario = load_scenario("safe-simulation")
    plain, watched = (build(settle(scenario, law)) for build in (controller, watched_controller))
    graphs = [s.function("f", [s.update, s.y, s.d]).serialize() for s in (plain, watched)]

    assert graphs[0] == graphs[1]
    assert plain.p0 == watched.p0
    assert diagnostics(plain)[0] == diagnostics(watched)[0]


@every_law
@pytest.mark.slow_but("mb")
def test_the_monitor_comes_last(law: str) -> None:
    """State and diagnostics: the law's own first, as they were; then tau_applied, then watching."""
    scenario = scenario_of()
    bare, watched = law_graph(settle(scenario, law)), watched_controller(settle(scenario, law))
    own, further = len(bare.state), [item.signal.name for item in watched.state]

    assert diagnostics(watched)[0] == [*diagnostics(bare)[0], *GUARD_DIAGNOSTICS]
    assert further[:own] == [item.signal.name for item in bare.state]
    assert further[own:] == ["tau_applied", "guard_v", "guard_started"]
    assert compile_law(law).state[: bare.x.numel()] == tuple(
        name for item in bare.state for name in item.signal.elements
    )


@every_law
def test_dbar_is_a_parameter_with_its_units(law: str) -> None:
    given = {"guard.dbar": [12.0, 3.0]}
    listed = watched_controller(settle(scenario_of(**given), law)).params
    params = {item.signal.name: item for item in listed}

    assert params["guard.dbar"].value == (12.0, 3.0)
    assert params["guard.dbar"].signal.units == ("N", "N.m")


@pytest.mark.parametrize(
    ("law", "changed", "feasible"),
    [
        ("pid", {}, 1.0),
        ("smc", {"actuator.tau_max": 6.5}, 1.0),
        pytest.param("mb", {"actuator.tau_max": 5.0}, 0.0, marks=pytest.mark.slow),
        pytest.param("pursuit", {"guard.dbar": [1e4, 1.0]}, 0.0, marks=pytest.mark.slow),
        pytest.param("prox", {"guard.M_min": [0.1, 0.01]}, 0.0, marks=pytest.mark.slow),
    ],
)
def test_bounds_that_cannot_be_met_are_told_not_refused(
    law: str, changed: dict[str, Any], feasible: float
) -> None:
    scenario = scenario_of(**changed)

    assert diagnostics(watched_controller(settle(scenario, law)))[1][-1] == feasible
    assert (simulate(scenario, law)["feasible"] == feasible).all()
    if law in NAMES:
        assert (oracle.simulate(scenario, law)["feasible"] == feasible).all()


def drawn(draw: np.random.Generator) -> dict[str, Any]:
    """Settings of a guard about as often possible as not."""
    some: dict[str, Any] = {
        "actuator.tau_max": draw.choice([np.inf, 10 ** draw.uniform(0, 2)]),
        "guard.dbar": [10 ** draw.uniform(0, 3.5), 10 ** draw.uniform(-1, 3)],
        "guard.nbar": [draw.uniform(0, 0.7), draw.uniform(0, 1.0)],
        "guard.alpha": draw.uniform(10, 110),
        "guard.M_min": [draw.uniform(20, 70), draw.uniform(2, 7.5)],
        "guard.f_min": [10 ** draw.uniform(0, 3), draw.uniform(0, 10)],
        "guard.f_speed": [draw.uniform(0, 1.1), draw.uniform(0, 1.6)],
        "guard.brake": [draw.uniform(0, 200), draw.uniform(0, 40)],
        "guard.brake_share": draw.uniform(0, 1),
        "clock.control": draw.choice([0.01, 0.05, 0.1]),
    }
    chosen = draw.permutation(list(some))[: draw.integers(0, 4)]
    return {key: np.array(some[key]).tolist() for key in chosen}


def refused(scenario: Scenario, law: str) -> bool:
    try:
        settle(override(scenario, {"guard.enabled": True, "guard.trust": True}), law)
    except ScenarioError:
        return True
    return False


@pytest.mark.slow
def test_feasible_is_zero_exactly_where_a_guard_would_refuse() -> None:
    """In the graph and in its NumPy twin, for settings at random."""
    draw, told = np.random.default_rng(3), []
    for _ in range(25):
        scenario = load_scenario("paper-simulation", drawn(draw))
        wanted = float(not refused(scenario, "pid"))
        assert diagnostics(watched_controller(settle(scenario, "pid")))[1][-1] == wanted, (
            scenario.guard
        )
        assert VelocityGuard(scenario, scenario.actuator.tau_max).feasible == wanted
        told.append(wanted)

    assert 5 < sum(told) < 21
