"""Runs on the rigid body: the product's own loop on one side of the wheels."""

import numpy as np
import pytest

from tests.papers_robot import preset
from tests.tables import cases
from wmr_ctrl import simulate
from wmr_ctrl.core.signals import PLANT_STATE, RIGID
from wmr_ctrl.simulation.coupled import Coupled
from wmr_ctrl.simulation.engines import runnable
from wmr_ctrl.simulation.physics.run import figures_from_run, rigid_row, run_to_end
from wmr_ctrl.world.scenario import load_scenario

SHORT = {"clock.duration": 4.0, "actuator.tau_max": 10.0}


@pytest.mark.parametrize(
    "law, told",
    cases("""
        mb | disturbance.push = [5.0, 1.0]
        nn | sensor.velocity_noise = [0.01, 0.02]; sensor.pose_noise = 0.01 | slow
        prox | actuator.delay = 0.013; guard.enabled = true; disturbance.truncate = 3.0 | slow
    """),
)
def test_the_loop_without_its_plant_is_the_native_loop_to_the_bit(law, told):
    """Given the states of a native run, it logs the same."""
    chosen = preset("paper-simulation", "clock.duration = 2.0", told)
    run = simulate(chosen, law, seed=5)
    loop = runnable(chosen, law, "mujoco")
    coupled = Coupled(loop.compiled, 5, loop.scenario.clock.plant)
    names = [name for item in loop.compiled.layout.columns for name in item.elements]
    native = np.column_stack([run[name] for name in names])
    states = np.column_stack([run[item.name] for item in PLANT_STATE])
    step = 0
    for state, row in zip(states.tolist(), native, strict=True):
        shown = coupled.sampled(state)
        assert np.array_equal(shown[-len(names) :], row, equal_nan=True), step
        for _ in range(loop.scenario.clock.substeps):
            coupled.acting(shown[: -len(names)])
            step += 1
            coupled.ends(state, step)
    assert coupled.monitor().max_abs_v <= run.monitor.max_abs_v


def test_below_traction_it_is_the_plane_model():
    rigid, plane = (
        simulate("paper-simulation", "mb", seed=11, plant=plant, overrides=SHORT)
        for plant in ("mujoco", "ode")
    )
    assert rigid.outcome == plane.outcome == "completed"
    assert rigid.settings.plant_kind == "mujoco"
    assert np.array_equal(rigid["noise_right"], plane["noise_right"])
    away = np.hypot(rigid["x"] - plane["x"], rigid["y"] - plane["y"])
    assert away.max() < 0.05
    seen = rigid.monitor.rigid
    assert seen.tipped is None
    assert seen.slipped is None
    assert seen.least_tip_margin > 0.5


def test_the_log_has_wheel_speeds_slip_and_tilt():
    run = simulate("paper-simulation", "mb", plant="mujoco", overrides=SHORT)
    assert run.signals[-len(RIGID) :] == RIGID
    r, half_track = 0.1, 0.25
    for i, side in enumerate((1.0, -1.0)):
        ground = run["v1"] + side * half_track * run["omega"]
        assert run["slip"][:, i] == pytest.approx(r * run["wheel_speed"][:, i] - ground, abs=1e-12)
    assert np.abs(run["slip"]).max() <= run.monitor.rigid.max_slip
    assert run["tilt"].max() <= run.monitor.rigid.max_tilt


def test_encoders_read_the_wheels_and_not_the_body():
    """Counts are whole parts of each wheel's own turn, also while it spins."""
    run = simulate("paper-simulation", "mb", plant="mujoco",
                   overrides={"encoder.counts": 4096, "clock.duration": 1.0})  # fmt: skip
    counted = np.diff(run["wheel_counts"], axis=0).sum(axis=0) / 4096 * 2 * np.pi
    turned = run["wheel_speed"].mean(axis=0) * run["t"][-1]
    assert np.abs(run["slip"]).max() > 1.0
    assert counted == pytest.approx(turned, rel=0.15)
    assert run.monitor.violations == 0


def test_a_row_of_a_table_is_that_of_the_whole_run():
    loop = runnable(load_scenario("paper-simulation", {"clock.duration": 0.1}), "mb", "mujoco")
    run, end = run_to_end(loop, 3)
    figures = figures_from_run(run, end)
    row = rigid_row(loop, 3)

    assert (len(end), run.rows) == (5, 10)
    assert figures.items() <= row.items()
    assert end[0] in figures.values()
    assert row["seed"] == 3
