"""The compiled loop against the oracle and against properties of any loop."""

import itertools
import re
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from tests import oracle
from tests.equal_runs import runs_equal
from tests.oracle import noise
from tests.papers_robot import preset
from tests.tables import cases, changes
from wmr_ctrl.api import compile_law, export_fmu, simulate
from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.core.signals import LARGEST
from wmr_ctrl.world.registry import Disturbance
from wmr_ctrl.world.scenario import Scenario

SHORT = changes("""
clock.duration = 6.0
changes = [{t = 3.0, m = 65.0, I = 7.0, mu = 0.15}, {t = 4.5, m = 40.0, I = 4.0, mu = 0.05}]
""")
SAMPLE = (0.1, 0.0, -1.5, 0.2, 0.1, 0.0, 0.0, -0.1, -0.2, -0.7, 0.1, 0.05)


def largest_gap(first, second):
    return max(float(np.nanmax(abs(first[s.name] - second[s.name]))) for s in first.signals)


@pytest.mark.slow
def test_both_engines_equal_the_oracle_over_80_s():
    slow = oracle.simulate("paper-simulation", "nn", seed=5)
    for engine in ("native", "numpy"):
        run = simulate("paper-simulation", "nn", seed=5, engine=engine)

        assert largest_gap(run, slow) < 1e-9
        assert run.monitor.violations == slow.monitor.violations
        assert run.monitor.max_abs_v == pytest.approx(slow.monitor.max_abs_v, abs=1e-9)


@pytest.mark.parametrize(
    "law, told",
    cases("""
        mb | actuator.tau_max = 10.0
        pid | actuator.lag = 0.02; actuator.delay = 0.005 | slow
        kanayama | disturbance.truncate = 1.5 | slow
        prox | sensor.velocity_noise = [0.02, 0.03] | slow
        nn | sensor.pose_period = 0.1; sensor.pose_noise = 0.05; sensor.correction = 0.2 | slow
        pursuit | reference.kind = "lemniscate" | slow
    """),
)
def test_every_option_equals_the_oracle(law, told):
    given = {**SHORT, **changes(told)}
    native, slow = (
        run("paper-simulation", law, seed=2, overrides=given) for run in (simulate, oracle.simulate)
    )
    numpy = simulate("paper-simulation", law, seed=2, overrides=given, engine="numpy")

    assert native.rows == slow.rows == numpy.rows
    assert largest_gap(native, slow) < 1e-8
    assert largest_gap(native, numpy) < 1e-8
    assert native.monitor.violations == slow.monitor.violations == numpy.monitor.violations


def test_seed_gives_the_same_bits_for_any_number_of_workers():
    def run(seed):
        return simulate("paper-simulation", "nn", seed=seed, overrides=SHORT)

    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(run, range(6)))
    alone = list(map(run, range(6)))

    assert all(map(runs_equal, alone, together))
    assert not runs_equal(alone[0], alone[1])


def test_truncated_noise_is_drawn_again_if_either_number_is_beyond():
    run = simulate("paper-simulation", "mb", overrides={**SHORT, "disturbance.truncate": 1.5})
    drawn = noise.torque_noise(noise.key_of(0), run.rows, Disturbance(std=1.0, truncate=1.5))

    assert np.abs(drawn).max() <= 1.5
    assert np.abs(drawn - np.column_stack([run["noise_right"], run["noise_left"]])).max() < 1e-12


def test_noise_that_is_never_within_its_bound_is_clipped():
    """Noise is clipped on either side; one pair in a million is within a thousandth."""
    rare = {"clock.duration": 1.0, "disturbance.truncate": 1e-3}
    run = simulate("paper-simulation", "mb", overrides=rare)
    drawn = run["noise_right"], run["noise_left"]

    assert {(x.min(), x.max()) for x in drawn} == {(-1e-3, 1e-3)}


def test_change_acts_on_the_first_plant_step_that_starts_at_it():
    """Without a change both runs agree up to t = 3 s and differ after the next plant step."""
    same, heavier = (
        simulate(preset("paper-simulation-nominal", "clock.duration = 6.0", change), "mb")
        for change in ("changes = []", "changes = [{t = 3.0, m = 65.0}]")
    )
    apart = np.flatnonzero(same["v1"] != heavier["v1"])

    assert same.time[apart[0]] == pytest.approx(3.01)


def test_compiled_law_steps_like_the_loop():
    run = simulate("paper-simulation-nominal", "pid", overrides={"clock.duration": 1.0})
    law = compile_law("pid", "paper-simulation-nominal")
    for k in range(100):
        law.u[:] = [run[name][k] for name in law.inputs]
        torque = law.step()
        assert (torque == (run["tau_right"][k], run["tau_left"][k])).all()


@pytest.mark.parametrize("law", NAMES)
@pytest.mark.slow_but("nn", "prox")
def test_a_compiled_law_refuses_what_no_robot_has_and_goes_on_as_before(law):
    one = compile_law(law)
    one.u[:] = SAMPLE
    one.step()
    kept, places = one.x.copy(), range(len(SAMPLE))
    for at, size in itertools.product(places, (1.7e308, -1.7e308, 1.1e12, np.inf, np.nan)):
        one.u[:] = SAMPLE
        one.u[at] = size
        with pytest.raises(ArgumentError, match=re.escape(f"{one.inputs[at]} = ")):
            one.step()
        assert (one.torque == 0).all()
        assert (one.x == kept).all()
    for at, sign in itertools.product(places, (-1.0, 1.0)):
        one.u[:] = SAMPLE
        one.u[at] = sign * LARGEST
        assert np.isfinite(one.step()).all()
        assert np.isfinite(one.x).all()
        one.reset()


@pytest.mark.parametrize(
    "error, message, call",
    [
        (ScenarioError, "effects = none must map", lambda: Scenario(effects=None)),
        (ArgumentError, "'simulink' .* plant", lambda: export_fmu("simulink", plant="a.fmu")),
        (ArgumentError, "'plant' .* plant", lambda: export_fmu("plant", plant="a.fmu")),
        (ArgumentError, "'modelica' .* fmi", lambda: export_fmu("modelica", fmi=3)),
    ],
)
def test_an_option_of_another_kind_is_refused_by_name(error, message, call):
    """Python allows any value anywhere; each is refused as a wrong one in a file is."""
    with pytest.raises(error, match=f"(?i){message}"):
        call()
