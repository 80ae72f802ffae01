"""`identify` writes what was stated or found, and lists everything else as assumed."""

import math
import re
import tomllib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import wmr_ctrl.identification.identification as identifying
from benchmarks.own_axes import Axis, Base, Truth
from benchmarks.own_plant import log_of
from tests.identification.conftest import KNOWN, NUMBERS, TRUTH, drive
from tests.papers_robot import paper
from tests.tables import changes
from wmr_ctrl import identify
from wmr_ctrl.cli import root
from wmr_ctrl.cli.check_sentences import promise
from wmr_ctrl.control.filter import command_filter
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.unstated import Unknown
from wmr_ctrl.identification.estimate import bare_scenario
from wmr_ctrl.identification.logs.log import LogError
from wmr_ctrl.identification.stated import believed
from wmr_ctrl.identification.written import outward
from wmr_ctrl.world.robot_files.found import Found, Rank, merged
from wmr_ctrl.world.scenario import inherited, load_scenario, loads_scenario, override
from wmr_ctrl.world.scenario.new import new_scenario
from wmr_ctrl.world.scenario.toml_io import preset_names

VELOCITY = [name for name in preset_names() if load_scenario(name).base.kind == "velocity"]
LOG = drive()
UNSHOWN = {"filter.gain", "filter.d"}


def of(stated="", log=LOG, **options):
    return identify(log, base="velocity", overrides=changes(stated), **options)


def assumed(found):
    return {*found.scenario.assumed}


def test_limits_that_nobody_stated_are_those_of_the_log_and_are_called_assumed(based, tmp_path):
    (tmp_path / "mine.toml").write_text(text := based.to_toml())

    scenario = load_scenario(tmp_path / "mine.toml")

    for limit, name in zip(scenario.limits.v_u1, ("v1", "omega"), strict=True):
        unit = "m/s" if name == "v1" else "rad/s"
        fastest = max(map(abs, LOG[f"{name}_measured [{unit}]"]))
        assert 0.85 * fastest < limit < fastest
    assert scenario.filter.kind == "clip"
    assert {item.key for item in inherited(scenario)} == {"limits.v_u1", "reference.kind"}
    assert isinstance(scenario.robot.m, Unknown)
    assert any("nobody stated limits.v_u1" in text for text in based.remarks)
    assert "seen in the log, not your limit" in text


def test_each_axis_has_its_own_bounds_and_wheels_those_of_both(based):
    again = loads_scenario(based.to_toml()).filter
    for name in ("tau", "gain"):
        both = based.scenario.filter.intervals(name)
        for axis, (own, other) in enumerate(zip(both, both[::-1], strict=True), 1):
            truth = NUMBERS[f"{name}{axis}"]
            assert own[0] < truth < own[1]
            assert not other[0] < truth < other[1]
        assert again.intervals(name) == both
    wheels = of("filter.channels = wheels; robot.l = 0.3").scenario.filter
    (low, _), (_, high) = sorted(both)
    assert (wheels.kind, wheels.gain) == ("clip", (low, high))


def test_what_was_stated_is_written_though_it_is_as_by_default_and_is_not_assumed():
    found = of("limits.v_u1 = [0.3, 0.6]; limits.v_u2 = [0.2, 0.5]; robot.m = 50.0")
    written = tomllib.loads(found.to_toml())

    assert written["robot"]["m"] == 50.0
    assert written["limits"]["v_u1"] == [0.3, 0.6]
    assert not {"limits.v_u1", "limits.v_u2", "robot.m"} & {*written["assumed"]}
    assert found.scenario.filter.kind == "clip"


def test_a_filter_is_wider_up_to_twice_the_speeds_of_its_log_and_off_beyond(based):
    found = of("limits.v_u1 = [1.2, 0.9]; limits.v_u2 = [0.6, 0.5]")

    assert found.scenario.filter.kind == "none"
    (said,) = (text for text in found.remarks if "the filter is off" in text)
    assert "1.2 m/s" in said
    most = float(said.split("at most ")[1].split(" m/s")[0])
    scenario = loads_scenario(found.to_toml())
    assert {*scenario.assumed} >= UNSHOWN
    assert "state filter.gain, filter.d: nobody did" in promise(settle(scenario, "kanayama"))
    on = override(scenario, {"filter.kind": "clip"})
    assert "within assumed bounds" in promise(settle(on, "kanayama"))

    near = of(f"limits.v_u1 = [{most}, 0.9]; limits.v_u2 = [0.1, 0.5]")
    assert near.scenario.filter.kind == "clip"
    assert near.bounds.d[0] == pytest.approx(2 * based.bounds.d[0], rel=0.1)
    wider, own = (item.scenario.filter.intervals("gain") for item in (near, based))
    assert wider[0][1] > own[0][1]
    assert wider[1][1] == pytest.approx(own[1][1], rel=0.01)
    assert assumed(near) >= UNSHOWN
    assert any("beyond the fastest motion of the log" in text for text in near.remarks)


def test_a_filter_that_is_refused_is_off():
    """Temporary large errors of the readings cause a deviation above the limit."""
    speed = np.array(LOG["v1_measured [m/s]"])
    speed[300:310] += 0.6

    found = of(log=LOG | {"v1_measured [m/s]": speed.tolist()})

    assert found.scenario.filter.kind == "none"
    assert any("the filter is off: with these numbers it is refused" in x for x in found.remarks)


def test_a_log_of_one_direction_switches_the_filter_off():
    found = of(log=drive(kind="forward"))

    assert found.scenario.filter.kind == "none"
    assert any("does not show what the base does in the other" in text for text in found.remarks)
    assert assumed(found) >= UNSHOWN


def test_a_filter_rests_on_what_is_assumed_between_the_speeds_of_a_log():
    """The log has speeds of 0.25 and 0.5 m/s only, so it lacks most commands of the filter."""
    found = of("limits.v_u1 = [0.2, 0.9]; limits.v_u2 = [0.1, 0.5]", drive(kind="levels"))

    assert found.scenario.filter.kind == "clip"
    assert sum(text.startswith("v_command was never from") for text in found.remarks) == 2
    assert assumed(found) >= UNSHOWN


def test_a_base_that_no_loop_explains_keeps_the_limits_of_its_filter():
    """The base keeps the limits although it is 0.1 m/s and 0.4 rad/s slower than its commands."""
    truth = Truth((Axis(first=0.15, offset=0.1), Axis(offset=0.4)))
    log = drive(truth)
    v, omega = of(log=log).scenario.limits.v_u1
    limits = f"limits.v_u1 = [{1.5 * v}, {1.5 * omega}]; limits.v_u2 = [{v}, {omega}]"
    scenario = of(limits, log).scenario

    assert scenario.filter.kind == "clip"
    for asked in ((9.0, 0.0), (0.0, 9.0), (9.0, 9.0)):
        filtered, base = command_filter(scenario), Base(truth)
        for k in range(200):
            sign = 1 if k // 40 % 2 == 0 else -1
            command = filtered.step((sign * asked[0], sign * asked[1])).command
            for _ in range(20):
                base.step(command)
            assert (np.abs(base.v) <= scenario.limits.v_u1).all()


@pytest.mark.parametrize("rate", [7.0, 29.9, 30.0, 50.0])
@pytest.mark.parametrize("name", VELOCITY)
def test_every_base_that_is_included_can_be_put_on_the_clock_of_a_log(name, rate):
    known = override(load_scenario(name), {"sensor.pose_period": 0.1, "clock.duration": 80.0})

    bare = bare_scenario(known, SimpleNamespace(period=1 / rate), remarks := [])

    assert bare.base.delay == 0.0
    ratio = bare.sensor.pose_period / bare.clock.control
    assert ratio == pytest.approx(round(ratio))
    assert math.isclose(bare.sensor.pose_period, 0.1, abs_tol=1 / rate)
    told = any("sensor.pose_period = 0.1 s becomes" in text for text in remarks)
    assert told is (abs(bare.sensor.pose_period - 0.1) > 1e-9)


def test_known_guards_and_delays_do_not_stop_a_log_of_another_clock():
    stated = "guard.delay = [0.0, 0.01]; actuator.delay = 0.007; sensor.pose_delay = 0.03"
    known = override(paper(), changes(f"{stated}; encoder.counts = 2048; encoder.window = 0.05"))

    bare = bare_scenario(known, SimpleNamespace(period=0.0301), remarks := [])

    assert bare.actuator.delay == 0.0
    assert bare.value("encoder.window")[0] == pytest.approx(0.0602)
    assert len(remarks) == 2


def test_wheels_of_the_paper_are_not_taken_for_known(driven, tmp_path):
    (tmp_path / "known.toml").write_text("[limits]\nv_u1 = [0.5, 1.0]\nv_u2 = [0.4, 0.8]\n")
    counts = {"encoder.counts": TRUTH.counts}

    with pytest.raises(LogError, match=r"robot\.r and robot\.l must be known"):
        identify(log_of(driven, 0), known=tmp_path / "known.toml", overrides=counts)


def test_numbers_of_a_preset_that_a_file_extends_are_used(tmp_path):
    known, again = tmp_path / "known.toml", tmp_path / "found.toml"
    limits = "[limits]\nv_u1 = [0.3, 0.6]\nv_u2 = [0.2, 0.5]\n"
    known.write_text(f'extends = "turtlebot3-burger"\n{limits}')

    found = of(known=known)
    again.write_text(found.to_toml())

    assert found.scenario.robot.r == load_scenario("turtlebot3-burger").robot.r
    assert not {"robot.m", "robot.r", "limits.v_u1"} & assumed(found)
    assert {*load_scenario(again).assumed} == assumed(found)
    assert of(known=again).scenario.limits == found.scenario.limits


def test_limits_of_an_earlier_log_are_not_stated_ones(based, tmp_path):
    (tmp_path / "mine.toml").write_text(based.to_toml())
    faster = {key: [(1 + (key != "t [s]")) * item for item in LOG[key]] for key in LOG}

    found = of(log=faster, known=tmp_path / "mine.toml").scenario

    assert found.limits.v_u1[0] > 1.5 * based.scenario.limits.v_u1[0]
    assert found.filter.kind == "clip"


@pytest.mark.parametrize("speed", [0.05, 2.0])
def test_a_log_completes_a_scenario_whatever_its_limits(speed, tmp_path):
    """A scenario from `new` states only v_u1."""
    item = Found("limits.v_u1", (speed, 2 * speed), "f: x", Rank.CONTROLLER)
    (tmp_path / "mine.toml").write_text(new_scenario(merged([item]), "velocity", "mine").text)

    found = of(known=tmp_path / "mine.toml")

    assert "limits" not in tomllib.loads(found.to_toml())
    assert loads_scenario(found.to_toml()).limits.v_u1 == item.value
    assert not {"base.tau", "base.delay", "limits.v_u1"} & assumed(found)


def test_a_guard_keeps_to_the_speeds_and_torques_of_the_log(driven, found):
    """`found` knows only wheels and counts."""
    scenario, log = found.scenario, log_of(driven, 0)

    assert assumed(found) == {"limits.v_u1", "actuator.tau_max", "reference.kind"}
    most = min(max(map(abs, log[f"tau_{side} [N.m]"])) for side in ("right", "left"))
    assert 0.9 * most < scenario.actuator.tau_max <= most
    assert scenario.guard.enabled
    assert scenario.guard.dbar == found.bounds.dbar
    assert {*tomllib.loads(found.to_toml())["robot"]} == {"m", "I", "mu", "r", "l"}


@pytest.mark.parametrize("far, enabled", [(1.0, True), (1.5, True), (2.1, False)])
def test_limits_beyond_the_log_widen_a_guard_or_switch_it_off(found, far, enabled):
    values = {name: item.value for name, item in found.parameters.items()}
    limits = [far * item for item in found.scenario.limits.v_u1]
    base = override(found.scenario, {"guard.enabled": False, "limits.v_u1": limits})

    made = identifying._scenario("log", base, values, found.bounds, (far, far), remarks := [])

    assert made.guard.enabled is enabled
    assert made.guard.dbar == pytest.approx([far * item for item in found.bounds.dbar], rel=1e-3)
    assert any("fastest motion" in text for text in remarks) is (1.0 < far < 2.0)
    assert any("the guard is off" in text for text in remarks) is not enabled
    assert ("guard.dbar" in made.assumed) is (far > 1.0)


def test_the_limits_of_a_saved_run_are_stated_ones():
    scenario, sure, _ = believed(SimpleNamespace(base=paper()), None, {})

    assert scenario == paper()
    assert "limits.v_u1" in sure


def test_what_is_written_extends_the_users_file_and_has_found_keys_alone(tmp_path):
    known, out = tmp_path / "robot" / "data sheet.toml", tmp_path / "out"
    known.parent.mkdir()
    out.mkdir()
    known.write_text("[robot]\nr = 0.05\nl = 0.12\n[base]\ndelay = 0.5\n[limits]\nclip = 1e-5\n")
    found = of(known=known)
    (out / "mine.toml").write_text(text := found.to_toml(out))

    scenario, table = load_scenario(out / "mine.toml"), tomllib.loads(text)

    assert replace(scenario, name="identified") == found.scenario
    assert table["extends"] == "../robot/data sheet.toml"
    assert not {"robot", "initial", "sensor"} & {*table}
    assert {*table["limits"]} == {"v_u1"}
    assert "limits.v_u1" in scenario.assumed
    interval = r"tau1 0\.\d+ to 0\.\d+ s, determined; tau2 .*; from log, 12 s"
    assert re.search(rf"tau = \[0\.\d{{1,4}}, 0\.\d{{1,4}}\] .*{interval}", text)


def test_intervals_are_rounded_outward_to_four_digits():
    for value in (0.25, 0.0, math.inf):
        assert outward(value, value) == (value, value)
    assert outward(1234.56, 1234.56) == (1234.0, 1235.0)
    assert outward(-0.0123456, -0.0123456) == (-0.01235, -0.01234)


def test_short_logs_count_as_one_and_rest_between():
    several = [drive(seed=seed, seconds=2.5, held=(2.0, 2.0)) for seed in range(6)]

    found = of(log=several)

    for name, truth in NUMBERS.items():
        item = found.parameters[name]
        assert item.verdict in ("determined", "roughly"), name
        assert item.value == pytest.approx(truth, rel=0.05, abs=0.002), name
    one = of(log=several[:1])
    assert one.scenario.filter.kind == "none"
    assert one.to_toml()
    other = {"t [s]": [0.0, 1.0], "v1 [m/s]": [0.0, 0.0], "omega [rad/s]": [0.0, 0.0]}
    with pytest.raises(LogError, match="no column is in all"):
        of(log=[several[0], other])


def test_constant_columns_determine_nothing_and_are_no_error(tmp_path):
    log = {key: [0.3] * 1000 for key in LOG} | {"t [s]": [0.02 * k for k in range(1000)]}
    rest = {"v1_measured [m/s]": [0.0] * 1000}
    found, silent = of("limits.v_u1 = [1.0, 2.0]", log), of(log=log | rest)
    file = tmp_path / "mine.toml"
    file.write_text(found.to_toml())

    assert {key: item.verdict for key, item in found.parameters.items()} == dict.fromkeys(
        NUMBERS, "undetermined"
    )
    assert any("Change both commands by steps" in text for text in found.remarks)
    assert found.traces().measured.shape == (1000, 2)
    assert tomllib.loads(file.read_text())["base"] == {"kind": "velocity"}
    assert load_scenario(file).filter.kind == "none"
    assert (found.missing, silent.missing) == ((), ("limits.v_u1",))
    file.write_text(silent.to_toml())
    with pytest.raises(ScenarioError, match=r"missing: limits\.v_u1"):
        load_scenario(file)


@pytest.mark.slow
def test_constant_torques_determine_nothing_and_are_no_error(driven):
    log = log_of(driven, 0)
    still = {key: [0.5] * len(row) if key.startswith("tau") else row for key, row in log.items()}

    found = identify(still, overrides=KNOWN | {"robot.m": 20.0})

    assert {item.verdict for item in found.parameters.values()} == {"undetermined"}
    assert not found.scenario.guard.enabled
    assert any("determines nothing" in text for text in found.remarks)
    assert found.scenario.robot.m == 20.0
    assert found.missing == ("robot.I",)
    assert any("missing" in text and "robot.I [kg.m2]" in text for text in found.remarks)


def test_a_result_that_one_file_cannot_hold_writes_none(based, tmp_path, monkeypatch, capsys):
    torques = replace(based, bounds=SimpleNamespace(section="guard", sentence="seen"))
    monkeypatch.setattr("wmr_ctrl.identification.identify", lambda *_, **__: torques)
    out, nav2 = (str(tmp_path / name) for name in ("mine.toml", "nav2.yaml"))

    with pytest.raises(SystemExit, match="2"):
        root.main(["identify", "log.csv", "--out", out, "--nav2", nav2])

    assert "this base takes torques" in capsys.readouterr().err.replace("\n  ", " ")
    assert not [*tmp_path.iterdir()]
