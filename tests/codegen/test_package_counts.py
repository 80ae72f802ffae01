"""Wheel counts and angles in C packages grow without limit, and no robot stops for it."""

import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.board.emulated import HostBuild
from tests.codegen import measured
from tests.codegen.packages import write_package
from tests.codegen.test_package import WARNINGS, needs, run
from tests.commands import finished
from wmr_ctrl.codegen.package import package_files
from wmr_ctrl.core.errors import ArgumentError, ScenarioError
from wmr_ctrl.world.scenario import load_scenario

HOURS = Path(__file__).parent / "ten_hours.c"
FINE = {"encoder.counts": 61440, "gyro.enabled": False, "guard.alpha": 6.0}
"""A geared encoder on both axes, and what the guard needs with it."""
GOOD = np.array([0.1, 0.0, -1.5, 0.2, 0.1, 0.0, 0.0, 0.099, 0.001, -1.501])
TAKEN, REFUSED, AMBIGUOUS = 0, 1, 2
STEPS = np.cumsum([(0, 0), (3, 2), (4, 1), (5, -3), (4, 2)], axis=0)
needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="NOT RUN: no cc")
every_counter = pytest.mark.parametrize("bits", [16, 32])
either = pytest.mark.parametrize("float32", [False, True], ids=["double", "float32"])


def with_bits(bits, window=0.02, counts=1024):
    stated = {"encoder.bits": bits, "encoder.window": window, "encoder.counts": counts}
    return load_scenario("paper-simulation", stated)


def torques(host, counts):
    host.reset()
    shown = [host.step(GOOD, row) for row in counts]
    assert not any(status for status, _ in shown)
    return [torque.tolist() for _, torque in shown]


@needs_cc
@every_counter
@pytest.mark.slow_but("16")
def test_ten_hours_of_a_fine_encoder_refuse_no_sample(bits, tmp_path):
    """Counters wrap, angles reach 600 turns: the robot keeps to its circle, and loses no count."""
    scenario = load_scenario("robot-10ms", {**FINE, "encoder.bits": bits})
    write_package("kanayama", tmp_path, scenario, float32=True)
    shutil.copy(HOURS, tmp_path)
    command = ["cc", "-std=c99", "-O2", "-ffp-contract=off", HOURS.name, "-lm", "-o", "hours"]
    finished(command, cwd=tmp_path)
    begin = 2**31 - 400_000_000
    arguments = [str(item) for item in (10, FINE["encoder.counts"], bits, begin)]
    done = finished(["./hours", *arguments], cwd=tmp_path)
    refused, far, wrong, right, left, *lost = map(float, done.stdout.split())

    assert (refused, *lost) == (0, 0, 0)
    assert max(far, wrong) < 1e-3
    assert right > left > 6e8


@every_counter
def test_a_microcontroller_counts_without_doubles(bits, tmp_path):
    needs(measured.COMPILER)
    write_package("mb", tmp_path, with_bits(bits), float32=True)
    command = [measured.COMPILER, *WARNINGS, "-Wdouble-promotion", "-O2", *measured.TARGET]
    run([*command, "-c", "wmr_mb.c"], tmp_path)

    assert "__aeabi_" not in run(["arm-none-eabi-nm", "wmr_mb.o"], tmp_path)


@needs_cc
@every_counter
@either
def test_torques_are_the_same_wherever_counters_begin(bits, float32, tmp_path):
    host = HostBuild("prox", with_bits(bits), tmp_path, float32=float32)
    half = 2 ** (bits - 1)
    plain = torques(host, STEPS)

    for begin in (half - 5, -5, 2 * half - 5, 2**31 - 5, 123_456_789):
        assert torques(host, STEPS + begin) == plain
        assert torques(host, (STEPS + begin) % (2 * half)) == plain
    assert torques(host, -STEPS) == torques(host, half - STEPS) != plain


@needs_cc
@every_counter
def test_half_of_the_range_is_refused_once_by_name(bits, tmp_path):
    """Half the range on either wheel gives torques of 0; the next sample counts from there."""
    host = HostBuild("mb", with_bits(bits, 0.0), tmp_path, float32=True)
    half = 2 ** (bits - 1)
    wanted = torques(host, np.array([(0, 0), (3, 2)]))[1]
    header = (tmp_path / "wmr_mb.h").read_text("utf-8")
    assert f"#define WMR_COUNTS_AMBIGUOUS {AMBIGUOUS}" in header
    for moved in ((half, 0), (0, half), (-half, 7)):
        host.reset()
        first, second, third = (
            host.step(GOOD, counts) for counts in ((0, 0), moved, np.add(moved, (3, 2)))
        )
        assert (first[0], second[0], *second[1]) == (TAKEN, AMBIGUOUS, 0, 0)
        assert (third[0], third[1].tolist()) == (TAKEN, wanted)
    for moved in ((half - 1, 0), (0, 1 - half)):
        torques(host, ((0, 0), moved))


@needs_cc
@either
def test_counts_of_refused_samples_are_counted(float32, tmp_path):
    """After two samples without pose the speed is that of one period, not of three."""
    host = HostBuild("mb", with_bits(16, 0.0), tmp_path, float32=float32)
    wanted = torques(host, np.array([(0, 0), (3, 2)]))[1]
    host.reset()
    host.step(GOOD, (0, 0))
    for counts in ((30_000, 5), (60_000, 9)):
        status, torque = host.step([*GOOD[:7], math.nan, *GOOD[8:]], counts)
        assert (status, *torque) == (REFUSED, 0, 0)
    status, torque = host.step(GOOD, (60_003, 11))

    assert (status, torque.tolist()) == (TAKEN, wanted)


@needs_cc
@either
def test_whole_turns_of_angles_do_not_matter(float32, tmp_path):
    """Continuous angles and a compass's angles give the same torques, to the angle's own digits."""
    host = HostBuild("prox", load_scenario("paper-simulation"), tmp_path, float32=float32)
    shown = []
    for turns in ((0, 0), (0, 1), (-2, 5), (600, 600), (200_000, 200_000)):
        given = np.append(GOOD, (0.19, 0.1))
        given[[2, 9]] += 2 * math.pi * np.array(turns)
        host.reset()
        status, torque = host.step(given)
        shown.append(torque)
        digits = np.spacing(host.real(abs(given[[2, 9]]).max()))
        assert status == TAKEN
        assert np.abs(torque - shown[0]).max() <= 1e-4 * float32 + 1e3 * digits


@pytest.mark.parametrize(
    "bits, counts, said",
    [(16, 2**22, r"by 9.179e\+04 counts .* below 32768"), (32, 1e12, "encoder.bits = 32")],
)
def test_limits_that_make_counts_ambiguous_are_refused(bits, counts, said):
    with pytest.raises(ArgumentError, match=said):
        package_files("mb", with_bits(bits, counts=counts))


@pytest.mark.parametrize("bits", [8, 24, 64])
def test_other_counters_are_refused(bits):
    with pytest.raises(ScenarioError, match=rf"encoder\.bits = {bits} must be 16 or 32"):
        with_bits(bits)
