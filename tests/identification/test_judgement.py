"""A fit judges itself: it names effects beside the loop, and reports unexplained motion."""

import re

import numpy as np
import pytest

from benchmarks.own_axes import Axis, Truth
from tests.identification.conftest import drive
from wmr_ctrl import RecordedDrive, identify
from wmr_ctrl.world.scenario import loads_scenario

TAU = 0.12
PLAIN = Axis(first=TAU)


def judged(first=PLAIN, second=PLAIN, log=None, **base):
    """Result for a base of two axes, driven alike by random steps."""
    alike = {"most": (0.5, 0.5), "noise": (0.003, 0.003), "seconds": 30.0} | (log or {})
    return identify(drive(Truth((first, second), **base), 0, **alike), base="velocity")


def diagnosis(found):
    return {(row["axis"], row["key"]) for row in found.to_json()["diagnosis"]}


BESIDE = {
    "": {},
    "offset": {"offset": 0.08},
    "saturation": {"most": 0.36},
    "sides": {"back": 0.85},
    "curve": {"curve": 0.6, "gain": 0.8},
    "bias": {"bias": 0.05},
    "dead-band": {"dead": 0.125},
    "decel": {"accel": 0.4, "decel": 1.5},
}


@pytest.mark.parametrize(
    "keys", [("", "offset"), ("saturation", "sides"), ("curve", "bias"), ("decel", "dead-band")]
)
def test_a_structure_beside_the_loop_is_found_and_named(keys):
    found = judged(*(Axis(first=TAU, **BESIDE[key]) for key in keys))

    assert diagnosis(found) == {*zip(("v", "omega"), keys, strict=True)} - {
        ("v", ""),
        ("omega", ""),
    }
    for judgement, key in zip(found.judgements, keys, strict=True):
        truth = {"gain": 1.0, "tau": TAU, "delay": 0.04, **BESIDE[key]}
        if "most" in truth:
            truth["sat"] = truth.pop("most")
        assert judgement.explained == "explained"
        assert judgement.fit.values == pytest.approx(truth, rel=0.04)


def test_a_gain_that_changed_midway_is_told_with_its_time_and_nothing_else():
    found = judged(then=(17.0, 0, 0.8))
    gain = found.parameters["gain1"]

    assert gain.share == pytest.approx((gain.high - gain.low) / 2 / gain.value)

    assert diagnosis(found) == {("v", "change")}
    (told,) = [text for text in found.remarks if "became" in text]
    assert re.match(r"v: the gain became 0\.(8|79)\d* times itself at about 1[67]", told)
    assert found.to_json()["explained"] == {"v": "in part", "omega": "explained"}
    assert found.parameters["gain1"].low < 0.8 < 1.0 < found.parameters["gain1"].high


def test_another_axis_that_changes_this_one_is_named():
    found = judged(log={"seconds": 40.0}, cross=0.4)

    assert ("omega", "coupling") in diagnosis(found)
    assert [item.plain for item in found.judgements] == [True, False]
    assert found.judgements[1].explained != "explained"


def test_a_slow_push_accuses_no_model():
    found = judged(log={"push": (0.02, 0.02, 0.5)})

    assert all(item.plain for item in found.judgements)
    assert found.parameters["gain1"].low < 1.0 < found.parameters["gain1"].high


def test_delays_that_differ_from_change_to_change_are_told():
    """Some commands act up to a row before they are logged."""
    found = judged(log={"timer": True})

    assert diagnosis(found) == {("v", "delay"), ("omega", "delay")}
    assert sum("Log them when they are sent" in text for text in found.remarks) == 2


@pytest.mark.parametrize(
    "kind, commands, motion", [("steps", 1, 1), ("steps", 2, 1), ("smooth", 1, 1), ("smooth", 3, 3)]
)
def test_delays_of_commands_that_are_logged_in_part_are_not_determined(kind, commands, motion):
    """A delay is determined only if the log has every command and its steps show this.

    With every second command logged, a command in between may have caused the motion. If commands
    change from row to row, nothing in the log shows that it has all of them.
    """
    base = Truth((Axis(), Axis()), (0.077, 0.077))
    log = {key.split(" ")[0]: np.array(row) for key, row in drive(base, kind=kind).items()}
    t = log.pop("t")
    every = {key: commands if key.endswith("command") else motion for key in log}
    part = [{key: of[key][::k] for key, k in every.items()} for of in (dict.fromkeys(log, t), log)]

    found = identify(RecordedDrive("log", *part), base="velocity")

    for name in ("delay1", "delay2"):
        delay = found.parameters[name]
        assert delay.low - 1e-3 < 0.077 < delay.high + 1e-3
        assert (delay.verdict == "determined") == (commands == 1 and kind == "steps")
    assert found.parameters["gain1"].value == pytest.approx(1.0, abs=0.01)


def test_a_loop_whose_sensor_would_hide_an_overshoot_is_told():
    """A PI loop behind readings that lag by 2 zeta/wn has the speed of a second-order loop."""
    axis = Axis("pi", first=8.0, zeta=0.7)

    found = judged(axis, axis, sensor=2 * axis.zeta / axis.first)

    assert found.scenario.base.loop == ("second-order", "second-order")
    for judgement in found.judgements:
        assert "a PI loop whose readings lag by 0.18 s looks alike" in judgement.sentence


@pytest.mark.parametrize(
    "speed",
    [
        lambda v: 0.3 * np.random.default_rng(5).normal(size=len(v)),
        lambda v: 0 * v,
        lambda v: 1e5 * v,
        lambda v: 1 / (v + 1e-3),
    ],
)
def test_speeds_that_no_command_explains_have_no_numbers_and_no_filter(speed):
    log = drive()
    log["v1_measured [m/s]"] = speed(np.array(log["v1_measured [m/s]"])).tolist()

    found = identify(log, base="velocity", overrides={"limits.v_u1": [0.5, 1.0]})

    assert found.to_json()["explained"] == {"v": "not explained", "omega": "explained"}
    assert [found.parameters[f"gain{k}"].verdict for k in (1, 2)] == ["not explained", "determined"]
    assert found.scenario.filter.kind == "none"
    assert any("the filter is off" in text for text in found.remarks)
    assert loads_scenario(found.to_toml()).base == found.scenario.base
