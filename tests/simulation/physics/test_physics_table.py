"""What is robust of the findings on the rigid body in docs/physics.md, on other seeds."""

from __future__ import annotations

import math

import pytest

from wmr_ctrl import Run, simulate
from wmr_ctrl.results import e_rms, ise

pytestmark = pytest.mark.slow

LIMITED = {"actuator.tau_max": 10.0}
STEADY, SEED = "paper-simulation-no-switch", 4100


def rigid(law: str, preset: str = STEADY, guard: bool | None = None, **overrides: object) -> Run:
    chosen = {key.replace("__", "."): value for key, value in overrides.items()}
    return simulate(preset, law, seed=SEED, plant="mujoco", guard=guard, overrides=chosen)


def ahead(run: Run, start: float, end: float) -> float:
    """RMS of e1 [mm]."""
    errors = e_rms(run, start, end)
    assert errors is not None
    return 1e3 * errors[0]


def test_below_traction_the_plane_model_is_right():
    body = rigid("mb", actuator__tau_max=10.0)
    plane = simulate(STEADY, "mb", seed=SEED, overrides=LIMITED)
    assert ise(body)["total"] == pytest.approx(ise(plane)["total"], rel=0.02)
    assert ahead(body, 30, 80) == pytest.approx(ahead(plane, 30, 80), abs=0.2)


@pytest.mark.parametrize(("law", "least", "most"), [("mb", 10.0, math.inf), ("nn", 1.0, 3.0)])
def test_after_the_switch_the_network_pays(law, least, most):
    body = rigid(law, "paper-simulation", actuator__tau_max=10.0)
    assert least < ahead(body, 70, 80) / ahead(body, 30, 40) < most


@pytest.mark.parametrize("law", ["mb", "nn", "pid", "smc"])
def test_without_a_limit_the_paper_s_laws_fall(law):
    assert rigid(law, "paper-simulation").outcome == "tipped"


def test_a_slope_is_an_error_of_the_model():
    body = rigid("mb", actuator__tau_max=10.0, body__slope=math.radians(5.0))
    assert 5.0 < ahead(body, 70, 80) < 20.0


def test_the_step_does_not_matter():
    usual, other = (
        rigid("mb", actuator__tau_max=10.0, clock__plant=h, clock__duration=20.0)
        for h in (1e-3, 2e-3)
    )
    assert ise(other)["total"] == pytest.approx(ise(usual)["total"], rel=0.01)


def test_a_guard_that_approaches_slowly_never_spins_the_wheels():
    body = rigid(
        "mb", guard=True, guard__alpha=5.0, disturbance__truncate=3.0, clock__duration=20.0
    )
    assert body.monitor.rigid.slipped is None
    assert body.monitor.violations == 0
