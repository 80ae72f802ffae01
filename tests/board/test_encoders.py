"""A package whose header takes wheel counts gives the loop's torques, here and on the board."""

import numpy as np
import pytest

from tests.board.emulated import BOARDS, Emulated, HostBuild, built, missing
from tests.codegen.measured import BOARD
from tests.codegen.packages import write_package
from tests.codegen.test_package import programs
from tests.compilers import where
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


GYRO = {"gyro.enabled": True}


def encoded(**more):
    return scenario_of("paper-simulation", {**ENCODED, **more})


def inputs_of(scenario):
    """Names of the inputs of NN's package."""
    return [item.signal.name for item in packaged(settle(scenario, "nn")).inputs]


def assert_torques_are_those_of_the_run(step, scenario):
    """Counts in, torques out; the header's other inputs are columns of the run, too."""
    run = simulate(scenario, "nn", seed=3)
    numbers = np.column_stack([run[name] for name in inputs_of(scenario)[:-1]])
    shown = [step(*sample) for sample in zip(numbers, run["wheel_counts"], strict=True)]
    assert not any(status for status, *_ in shown)
    wanted = np.column_stack([run["tau_right"], run["tau_left"]])
    assert np.array_equal([torque for _, torque, *_ in shown], wanted)


def test_counts_take_the_place_of_velocities_and_a_gyro_stays():
    names = [*(item.name for item in REFERENCE), "x", "y", "theta", "wheel_moved"]

    assert inputs_of(encoded()) == names
    assert inputs_of(encoded(**GYRO)) == [*names[:-1], "omega", "wheel_moved"]
    with pytest.raises(ArgumentError, match=r"encoder\.method = time"):
        inputs_of(encoded(**{"encoder.method": "time"}))


@pytest.mark.parametrize("more", [{}, GYRO], ids=["counts", "gyro"])
@pytest.mark.slow
def test_counts_in_torques_out_as_in_the_native_run(more, tmp_path):
    where("cc")
    host = HostBuild("nn", encoded(**more), tmp_path, float32=False)
    assert_torques_are_those_of_the_run(host.step, encoded(**more))


@pytest.mark.slow
def test_its_example_tracks_and_its_vectors_hold(tmp_path):
    write_package("nn", tmp_path, encoded(), float32=True)
    checked, example = programs("nn", tmp_path)

    assert "largest error" in checked
    assert float(example.split()[1]) < 0.1


@pytest.mark.skipif(bool(missing()), reason=missing())
@pytest.mark.slow
def test_the_emulated_board_gives_the_native_torques(tmp_path):
    firmware = built("nn", encoded(), BOARDS[BOARD], tmp_path, float32=False)
    with Emulated(firmware, BOARDS[BOARD], float32=False) as emulated:
        assert_torques_are_those_of_the_run(emulated.step, encoded())
