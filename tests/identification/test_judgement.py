"""A fit judges itself: structures beside the loop are named, and what nothing explains is told."""

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks import own_axes
from wmr_ctrl import RecordedDrive, identify
from wmr_ctrl.identification.judgement import judged
from wmr_ctrl.identification.logs.samples import AxisLog
from wmr_ctrl.identification.loop_search import axis_fit
from wmr_ctrl.identification.speed_loop import fitted, searched
from wmr_ctrl.world.scenario import loads_scenario

T, PERIOD, TAU, LATE = 40.0, 0.02, 0.12, 0.04
NAMES = ("gain", "tau", "delay")


def driven(acts=lambda u, t: u, seed=0, tau=TAU, push=lambda v, t, other: 0.0, other=0.0):
    """A log of one axis: random steps through ``acts``, a loop of first order in steps of 1 ms."""
    rng, inner = np.random.default_rng(seed), round(PERIOD / 1e-3)
    count = round(T / PERIOD)
    sent = np.repeat(rng.uniform(-0.5, 0.5, count // 40 + 1), 40)[:count]
    late, v, seen = round(LATE / 1e-3), 0.0, []
    other = np.broadcast_to(other, count)
    for k in range(count * inner):
        if k % inner == 0:
            seen.append(v)
        t = k * 1e-3
        u = acts(sent[(k - late) // inner] if k >= late else 0.0, t)
        v += (u + push(v, t, other[k // inner]) - v) * -math.expm1(-1e-3 / tau)
    t = PERIOD * np.arange(count)
    speed = np.array(seen) + 0.003 * rng.normal(size=count)
    inside = t > 1.0
    return AxisLog(t, speed, inside, t, sent, np.array([0]), of_way=False, period=PERIOD)


def ramped(up, down):
    now = 0.0

    def acts(u, _):
        nonlocal now
        rate = down if now * (u - now) < 0 else up
        now += float(np.clip(u - now, -rate * 1e-3, rate * 1e-3))
        return now

    return acts


@pytest.mark.parametrize(
    "acts, key, found",
    [
        (lambda u, t: u, None, {}),
        (lambda u, t: math.copysign(max(abs(u) - 0.08, 0.0), u), "offset", {"offset": 0.08}),
        (lambda u, t: min(max(u, -0.36), 0.36), "saturation", {"sat": 0.36}),
        (lambda u, t: u if u > 0 else 0.85 * u, "sides", {"back": 0.85}),
        (lambda u, t: 0.8 * u * (1 + 0.6 * abs(u)), "curve", {"curve": 0.6, "gain": 0.8}),
        (lambda u, t: u if t < 17.0 else 0.8 * u, "change", {"then": 0.8, "when": 17.0}),
        (lambda u, t: u + 0.05, "bias", {"bias": 0.05}),
        (ramped(0.4, 1.5), "decel", {"accel": 0.4, "decel": 1.5}),
    ],
)  # fmt: skip
def test_a_structure_beside_the_loop_is_found_and_named(acts, key, found):
    fit = axis_fit(driven(acts))
    judgement = judged(fit, None, 0)

    assert (fit.loop, {row["key"] for row in judgement.diagnosis()}) == (
        "first-order", {key} if key else set(),
    )  # fmt: skip
    assert judgement.explained == ("in part" if key == "change" else "explained")
    for name, value in {"gain": 1.0, "tau": TAU, "delay": LATE, **found}.items():
        near = 0.002 if name == "delay" else 0.04 * value
        assert fit.values[name] == pytest.approx(value, abs=near), name
    assert {*fit.values} == {*NAMES, *found}


def test_a_dead_band_lies_between_two_commands_of_the_log():
    log = driven(lambda u, t: u if abs(u) >= 0.15 else 0.0)
    fit = axis_fit(log)
    sizes = np.unique(np.abs(log.sent))
    place = np.searchsorted(sizes, fit.values["dead"])

    assert sizes[place - 1] < 0.15 <= sizes[place]


def plain_fit(log, **values):
    start = {"gain": 1.0, "tau": TAU, "delay": LATE} | values
    return fitted(log, "first-order", NAMES, searched(start, NAMES), 12)


def test_another_axis_that_changes_this_one_is_named():
    other = plain_fit(driven(seed=1))
    loses = driven(push=lambda v, t, o: -0.4 * abs(o) * np.sign(v), other=other.log.speed)

    judgement = judged(plain_fit(loses), other, 1)

    assert "coupling" in {row["key"] for row in judgement.diagnosis()}
    assert judgement.explained != "explained"
    assert judged(plain_fit(driven()), other, 1).plain


def test_a_slow_push_accuses_no_model():
    rng, state = np.random.default_rng(3), [0.0]

    def push(v, t, other):
        state[0] += -state[0] * 2e-3 + 0.02 * math.sqrt(4e-3) * rng.normal()
        return state[0]

    fit = axis_fit(driven(push=push))

    assert judged(fit, None, 0).plain
    assert fit.half_widths()["gain"] > abs(fit.values["gain"] - 1.0)


def test_delays_that_differ_from_change_to_change_are_told():
    """Commands that act up to a row before they are logged."""
    rng = np.random.default_rng(0)
    log = driven()
    steps = np.flatnonzero(np.diff(log.sent) != 0) + 1
    times = log.sent_t.copy()
    times[steps] += rng.uniform(0, 0.03, len(steps))

    (row,) = judged(plain_fit(replace(log, sent_t=times)), None, 0).diagnosis()

    assert row["key"] == "delay"
    assert "Log them when they are sent" in row["text"]


@pytest.mark.parametrize(
    "kind, commands, motion", [("steps", 1, 1), ("steps", 2, 1), ("smooth", 2, 1),
                                     ("steps", 2, 2), ("smooth", 1, 1), ("smooth", 3, 3)],
)  # fmt: skip
def test_delays_of_commands_that_are_logged_in_part_are_not_determined(kind, commands, motion):
    """With every second command logged, the one between may have caused what is seen.

    Nothing in a log of commands that change from row to row says that all of them are in it.
    """
    truth = own_axes.Truth((own_axes.Axis(), own_axes.Axis()), (0.077, 0.077))
    log = own_axes.recorded(truth, own_axes.Drive(period=PERIOD, kind=kind), seed=1)
    part = {True: slice(None, None, commands), False: slice(None, None, motion)}
    t = np.array(log.pop("t [s]"))
    rows = {name.split(" ")[0]: np.array(row) for name, row in log.items()}
    times, rows = (
        {name: of(name)[part[name.endswith("command")]] for name in rows}
        for of in (lambda _: t, rows.__getitem__)
    )

    found = identify(RecordedDrive("log", times, rows), base="velocity")

    for name in ("delay1", "delay2"):
        delay = found.parameters[name]
        assert delay.low - 1e-3 < 0.077 < delay.high + 1e-3
        assert (delay.verdict == "determined") == (commands == 1 and kind == "steps")
    assert found.parameters["gain1"].value == pytest.approx(1.0, abs=0.01)


def test_a_loop_whose_sensor_would_hide_an_overshoot_is_told():
    """A PI loop behind readings that lag by 2 zeta/wn has the speed of a second-order loop."""
    axis = own_axes.Axis("pi", first=8.0, zeta=0.7)
    truth = own_axes.Truth((axis, axis), sensor=2 * axis.zeta / axis.first)

    found = identify(own_axes.recorded(truth, own_axes.Drive(period=PERIOD), 1), base="velocity")

    assert found.scenario.base.loop == ("second-order", "second-order")
    for judgement in found.judgements:
        assert "a PI loop whose readings lag by 0.18 s looks alike" in judgement.sentence


def columns(log, other):
    return {
        "t [s]": log.t.tolist(),
        "v_command [m/s]": log.sent.tolist(),
        "omega_command [rad/s]": other.sent.tolist(),
        "v1_measured [m/s]": log.speed.tolist(),
        "omega_measured [rad/s]": other.speed.tolist(),
    }


@pytest.mark.parametrize(
    "speed",
    [
        lambda log, rng: 0.3 * rng.normal(size=len(log.t)),
        lambda log, rng: np.sin(3 * log.t),
        lambda log, rng: 0 * log.t,
        lambda log, rng: 1e-9 * log.speed,
        lambda log, rng: 1e5 * log.speed,
        lambda log, rng: 1 / (log.speed + 1e-3),
    ],
)
def test_speeds_that_no_command_explains_have_no_numbers_and_no_filter(speed):
    log = driven()
    odd = replace(log, speed=speed(log, np.random.default_rng(5)))
    found = identify(columns(odd, driven(seed=1)), base="velocity")

    assert found.to_json()["explained"] == {"v": "not explained", "omega": "explained"}
    assert found.parameters["gain1"].verdict == "not explained"
    assert found.parameters["gain2"].verdict == "determined"
    assert found.scenario.filter.kind == "none"
    assert any("the filter is off" in text for text in found.remarks)
    assert loads_scenario(replace(found, missing=()).to_toml()).base == found.scenario.base
