"""A package whose header takes wheel counts gives the loop's torques, here and on the board."""

import shutil
import subprocess

import numpy as np
import pytest

from tests.board.emulated import BOARDS, Emulated, HostBuild, built, missing
from tests.codegen.measured import BOARD
from tests.codegen.packages import write_package
from tests.tables import changes
from wmr_ctrl.api import simulate
from wmr_ctrl.codegen.package import packaged
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.signals import REFERENCE

ENCODED = changes("""
    encoder.counts = 1024
    encoder.window = 0.02
    clock.duration = 1.5
    wheels.radius = [0.02, 0.01]
""")
HOST = pytest.mark.skipif(shutil.which("cc") is None, reason="NOT RUN: no cc")


def encoded(**more):
    return scenario_of("paper-simulation", {**ENCODED, **more})


def given(run, *more):
    """What the package is given in each sample of a run: numbers, and counts."""
    names = [*(item.name for item in REFERENCE), "x", "y", "theta", *more]
    return zip(np.column_stack([run[name] for name in names]), run["wheel_counts"], strict=True)


def torques(run):
    return np.column_stack([run["tau_right"], run["tau_left"]])


def test_counts_take_the_place_of_velocities():
    names = [item.signal.name for item in packaged(settle(encoded(), "nn")).inputs]

    assert names == [*(item.name for item in REFERENCE), "x", "y", "theta", "wheel_moved"]


@HOST
@pytest.mark.slow
def test_counts_in_torques_out_as_in_the_native_run(tmp_path):
    run = simulate(encoded(), "nn", seed=3)
    host = HostBuild("nn", encoded(), tmp_path, float32=False)
    shown = [host.step(*sample) for sample in given(run)]

    assert not any(status for status, _ in shown)
    assert np.array_equal([torque for _, torque in shown], torques(run))


GYRO = {"gyro.enabled": True}


def test_a_gyro_stays_an_input():
    names = [item.signal.name for item in packaged(settle(encoded(**GYRO), "nn")).inputs]

    assert names[-2:] == ["omega", "wheel_moved"]


@HOST
@pytest.mark.slow
def test_rate_and_counts_in_torques_out_as_in_the_native_run(tmp_path):
    scenario = encoded(**GYRO)
    run = simulate(scenario, "nn", seed=3)
    host = HostBuild("nn", scenario, tmp_path, float32=False)

    shown = [host.step(*sample)[1] for sample in given(run, "omega")]

    assert np.array_equal(shown, torques(run))


@HOST
@pytest.mark.slow
def test_its_example_tracks_and_its_vectors_hold(tmp_path):
    write_package("nn", tmp_path, encoded(), float32=True)
    for program in ("example", "check"):
        subprocess.run(
            ["cc", "-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror",
             "-ffp-contract=off", f"{program}.c", "wmr_nn.c", "-lm", "-o", program],
            cwd=tmp_path, check=True, capture_output=True,
        )  # fmt: skip
    example, check = (
        subprocess.run([f"./{program}"], cwd=tmp_path, check=False, capture_output=True, text=True)
        for program in ("example", "check")
    )

    assert check.returncode == 0, check.stdout
    assert float(example.stdout.split()[1]) < 0.1


def test_counts_at_samples_do_not_tell_the_time_between_them():
    with pytest.raises(ArgumentError, match=r"encoder\.method = time"):
        packaged(settle(encoded(**{"encoder.method": "time"}), "nn"))


@pytest.mark.skipif(bool(missing()), reason=missing())
@pytest.mark.slow
def test_the_emulated_board_gives_the_native_torques(tmp_path):
    run = simulate(encoded(), "nn", seed=3)
    firmware = built("nn", encoded(), BOARDS[BOARD], tmp_path, float32=False)
    with Emulated(firmware, BOARDS[BOARD], float32=False) as emulated:
        shown = [emulated.step(*sample)[:2] for sample in given(run)]

    assert not any(status for status, _ in shown)
    assert np.array_equal([torque for _, torque in shown], torques(run))
