"""Bases that take velocities: runs of the package's own bases give their numbers back."""

import re

import numpy as np
import pytest
from scipy.signal import lsim

from tests.corridor.further import EXACT
from wmr_ctrl import RecordedDrive, identify, simulate
from wmr_ctrl.control.filter import command_filter
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.identification.logs.log import LogError
from wmr_ctrl.identification.logs.samples import AxisLog
from wmr_ctrl.identification.propose import propose
from wmr_ctrl.identification.speed_loop import foretold
from wmr_ctrl.report.identified import write_identification
from wmr_ctrl.world.scenario import loads_scenario

FIRST = {"tau": [0.25, 0.15], "gain": [0.95, 1.05], "delay": 0.03}
PI = {"loop": "pi", "kp": 150.0, "ki": 600.0, "delay": 0.04}


def steps(base, seconds=30.0, seed=0):
    """A log of random steps, by the loops' own equations in steps of 1 ms, with noisy speeds."""
    rng, T, h = np.random.default_rng(seed), 0.02, 1e-3
    count = round(seconds / T)
    u = rng.uniform((-0.5, -1.0), (0.5, 1.0), (count // 40 + 1, 2)).repeat(40, axis=0)[:count]
    late, inner = round(base["delay"] / h), round(T / h)
    sent = np.vstack([np.zeros((late, 2)), u.repeat(inner, axis=0)])
    v, ramped, seen = np.zeros(2), np.zeros(2), []
    for k in range(count * inner):
        if k % inner == 0:
            seen.append(v)
        most = np.asarray(base.get("accel", [np.inf, np.inf])) * h
        ramped = ramped + np.clip(sent[k] - ramped, -most, most)
        v = v + (np.array(base["gain"]) * ramped - v) * -np.expm1(-h / np.array(base["tau"]))
    noisy = np.array(seen) + rng.normal(size=(count, 2)) * (0.003, 0.006)
    names = ("v_command [m/s]", "omega_command [rad/s]")
    columns = {"t [s]": np.arange(count) * T}
    columns |= dict(zip(names, u.T, strict=True))
    names = ("v1_measured [m/s]", "omega_measured [rad/s]")
    columns |= dict(zip(names, noisy.T, strict=True))
    return {name: values.tolist() for name, values in columns.items()}


@pytest.fixture(scope="module")
def found():
    return identify(steps(FIRST, 12.0), base="velocity")


@pytest.mark.slow
def test_a_robots_drive_gives_what_its_columns_give(found):
    columns = {key.split(" ")[0]: np.array(row) for key, row in steps(FIRST, 12.0).items()}
    t = columns.pop("t")
    drive = RecordedDrive("log", dict.fromkeys(columns, t), columns)

    assert identify(drive, base="velocity").to_json() == found.to_json()


@pytest.mark.slow
def test_a_gain_that_changed_midway_is_told_with_its_time_and_nothing_else(found):
    first, last = steps(FIRST, 20.0), steps({**FIRST, "gain": [0.8, 1.05]}, 20.0, seed=1)
    last["t [s]"] = [t + 21.0 for t in last["t [s]"]]
    log = {key: first[key] + last[key] for key in first}

    changed = identify(log, base="velocity")
    told = [text for text in changed.remarks if "became" in text]
    assert len(told) == 1
    when = re.match(r"v: the gain became 0\.84\d* times itself at about ([\d.]+) s", told[0])
    assert when
    assert float(when[1]) == pytest.approx(20.5, abs=3.0)
    assert changed.parameters["gain1"].low < 0.8 < 0.95 < changed.parameters["gain1"].high
    assert not any("became" in text for text in found.remarks)


def test_speeds_of_sets_that_are_followed_together_are_those_of_each_alone():
    """However many they are, and whatever delays they have."""
    rng = np.random.default_rng(3)
    t, sent = 0.02 * np.arange(60), rng.uniform(-0.5, 0.5, 6).repeat(10)
    log = AxisLog(t, sent, np.ones(60, bool), t, sent, np.array([0, 25]), of_way=False, period=0.02)
    drawn = rng.uniform((0.8, 2.0, 0.3, 0.5, 0.0), (1.2, 9.0, 1.1, 3.0, 0.1), (9, 5))
    names = ("gain", "wn", "zeta", "accel", "delay")
    sets = [dict(zip(names, row, strict=True)) for row in drawn]
    together = foretold(log, "second-order", sets)

    assert np.ptp(together, axis=1).max() > 0.05
    for place, one in enumerate(sets):
        alone = foretold(log, "second-order", [one])
        assert together[:, place] == pytest.approx(alone[:, 0], abs=1e-12)


def near(item, truth):
    """Three half-widths: an interval of 95 % misses by that much once in 1e8."""
    return abs(item.value - truth) <= 3 * max(item.high - item.value, item.value - item.low)


@pytest.mark.slow
def test_a_first_order_base_gives_its_numbers_back(found):
    assert found.bounds.loop == "first-order"
    for axis in (1, 2):
        assert near(found.parameters[f"tau{axis}"], FIRST["tau"][axis - 1])
        assert near(found.parameters[f"gain{axis}"], FIRST["gain"][axis - 1])
        assert near(found.parameters[f"delay{axis}"], FIRST["delay"])
        for name in ("tau", "gain", "delay"):
            assert found.parameters[f"{name}{axis}"].verdict == "determined", name
    assert min(found.score.foretold) > 0.98


@pytest.mark.slow
def test_a_limit_that_was_never_met_is_not_told_and_has_no_upper_end(found):
    item = found.parameters["accel1"]

    assert item.verdict == "undetermined"
    assert item.high == np.inf
    assert item.low > 1.0
    assert any("acceleration limit" in text for text in found.remarks)


@pytest.mark.slow
def test_commands_that_are_lost_are_named_where_delays_are_undetermined(found):
    """A limit of 7.7 rad/s2 was told to be above 13.7 where one command in two may be lost."""
    square = {"reference.kind": "rounded-square", "reference.side": 3.0, "reference.corner": 0.8,
              "reference.speed": 0.2}  # fmt: skip
    start = {"initial.pose": [2.0, 2.0, 1.0], **square}
    told = {"base.losses": 1, "clock.duration": 15.0, **EXACT, **start}
    lossy = identify(simulate("irobot-create3", "pursuit", overrides=told), base="velocity")

    assert lossy.parameters["delay1"].verdict == "undetermined"
    assert any("commands were lost or came late by turns" in text for text in lossy.remarks)
    assert not any("lost" in text for text in found.remarks)


@pytest.mark.slow
def test_the_scenario_runs_behind_its_filter(found):
    scenario = loads_scenario(found.to_toml(), found.scenario.name)

    assert scenario == found.scenario
    assert scenario.filter.kind == "clip"
    command_filter(scenario)
    run = simulate(scenario, "kanayama", overrides={"clock.duration": 1.0})
    assert run.monitor.violations == 0
    # The peak gain of a family of first-order loops is its largest gain.
    gains = scenario.filter.intervals("gain")
    assert found.bounds.peak_gain == (gains[0][1], gains[1][1])


@pytest.mark.slow
def test_the_picture_and_the_page_are_those_of_a_base(found, tmp_path):
    traces = found.traces()
    write_identification(found, tmp_path / "fit.html", tmp_path / "fit.svg")

    largest = np.nanmax(np.abs(traces.residual), axis=0)
    assert (largest <= found.bounds.d).all()
    assert found.bounds.d == pytest.approx(largest, rel=1e-3)
    text = (tmp_path / "fit.html").read_text()
    assert "first-order" in text
    assert found.bounds.sentence in text


def test_a_proposed_drive_keeps_limits_and_floor(found):
    drive = propose(found, 3.0)

    assert np.hypot(*drive.path[:, :2].T).max() <= drive.farthest <= 1.5
    for speed, limit, fastest in zip(
        (drive.v, drive.omega), found.scenario.limits.v_u1, drive.fastest, strict=True
    ):
        assert np.abs(speed).max() <= limit
        assert fastest <= limit


def test_what_is_no_log_of_such_a_base_is_refused_by_name():
    log = steps(FIRST, 12.0)
    reversed_ = {**log, "v_command [m/s]": [-x for x in log["v_command [m/s]"]]}
    degrees = {**log, "omega_measured [rad/s]": [57.3 * x for x in log["omega_measured [rad/s]"]]}

    with pytest.raises(LogError, match="one of the two has the wrong sign"):
        identify(reversed_, base="velocity")
    with pytest.raises(LogError, match="degrees for radians"):
        identify(degrees, base="velocity")
    with pytest.raises(LogError, match="--base velocity"):
        identify(log)
    with pytest.raises(ArgumentError, match="torque, velocity"):
        identify(log, base="wheels")


@pytest.mark.slow
def test_an_acceleration_limit_is_told_apart_from_a_time_constant():
    base = {"tau": [0.1, 0.1], "gain": [1.0, 1.0], "delay": 0.02, "accel": [0.8, 2.0]}

    found = identify(steps(base, 16.0), base="velocity")

    for axis in (1, 2):
        assert near(found.parameters[f"accel{axis}"], base["accel"][axis - 1])
        assert found.parameters[f"tau{axis}"].value == pytest.approx(0.1, rel=0.15)
    assert found.scenario.filter.kind == "clip"


@pytest.mark.slow
def test_a_pi_loop_of_a_run_gives_its_peak_gain_back(tmp_path):
    """kp/M, ki/M and kp l^2/I of a run on encoders, and a filter for the family of them."""
    m, inertia, half = 50.0, 5.4, 0.25
    made = simulate("paper-simulation-noise-free", "kanayama", overrides={
        "changes": [], "base": {"kind": "velocity", **PI}, "clock.control": 0.02,
        "clock.duration": 20.0, "reference.kind": "stop-and-go", "encoder.counts": 4096,
        "robot.mu": 0.0, "disturbance.std": 0.2,
    })  # fmt: skip
    path = tmp_path / "run.npz"
    made.save(path)

    with pytest.raises(ArgumentError, match="--base velocity"):
        identify(path)
    found = identify(path, base="velocity")

    assert found.bounds.loop == "pi"
    for axis, mass in enumerate((m, inertia / half**2), 1):
        wn = np.sqrt(PI["ki"] / mass)
        assert found.parameters[f"wn{axis}"].value == pytest.approx(wn, rel=0.02)
        zeta = PI["kp"] / (2 * np.sqrt(PI["ki"] * mass))
        assert found.parameters[f"zeta{axis}"].value == pytest.approx(zeta, rel=0.03)
    assert found.scenario.filter.loop == ("pi", "pi")
    assert found.scenario.filter.kind == "clip", found.remarks


def test_an_axis_with_a_loop_of_the_other_kind_determines_only_what_both_kinds_say():
    """The speed v follows a first order, omega a second order: one scenario has one of both."""
    log = steps(FIRST, 24.0)
    fine = np.arange(24_000) * 1e-3
    late = np.repeat(log["omega_command [rad/s]"], 20)[np.arange(-50, len(fine) - 50)]
    late[:50] = 0.0
    omega = lsim(([100.0], [1.0, 14.0, 100.0]), late, fine, interp=False)[1][::20]
    noise = np.random.default_rng(1).normal(size=len(omega)) * 6e-3

    found = identify(log | {"omega_measured [rad/s]": (omega + noise).tolist()}, base="velocity")

    delay = found.parameters["delay1"]
    assert found.scenario.base.loop == ("second-order", "second-order")
    assert delay.low < FIRST["delay"] < delay.high
    assert all(found.parameters[name].verdict != "determined" for name in ("wn1", "zeta1"))
    assert found.parameters["wn2"].value == pytest.approx(10.0, rel=0.01)
