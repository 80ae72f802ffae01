"""`identify` writes what was stated or found, and lists everything else as assumed."""

import math
import re
import tomllib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

import wmr_ctrl.identification.identification as identifying
from benchmarks.own_plant import log_of
from tests.identification.conftest import KNOWN, TRUTH
from tests.identification.test_velocity_base import FIRST, steps
from tests.papers_robot import paper
from wmr_ctrl import identify
from wmr_ctrl.cli import root
from wmr_ctrl.cli.check_sentences import promise
from wmr_ctrl.control.filter import command_filter
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.unstated import Unknown
from wmr_ctrl.export.nav2 import nav2_of
from wmr_ctrl.identification.estimate import bare_scenario
from wmr_ctrl.identification.logs.log import LogError
from wmr_ctrl.identification.stated import believed
from wmr_ctrl.identification.written import outward
from wmr_ctrl.world.robot_files.found import Found, Rank, merged
from wmr_ctrl.world.scenario import inherited, load_scenario, loads_scenario, override
from wmr_ctrl.world.scenario.new import new_scenario
from wmr_ctrl.world.scenario.toml_io import preset_names

VELOCITY = [name for name in preset_names() if load_scenario(name).base.kind == "velocity"]
LOG = steps(FIRST, 12.0, 1)
FASTEST = [max(map(abs, LOG[name])) for name in ("v1_measured [m/s]", "omega_measured [rad/s]")]


def of_velocities(log=LOG, **overrides):
    keys = {key.replace("__", "."): value for key, value in overrides.items()}
    return identify(log, base="velocity", overrides=keys)


@pytest.fixture(scope="module")
def silent():
    """A log of which the user says nothing."""
    return of_velocities()


def test_limits_that_nobody_stated_are_those_of_the_log_and_are_called_assumed(silent, tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(silent.to_toml())

    scenario = load_scenario(file)
    taken = [item.key for item in inherited(scenario)]

    for limit, fastest in zip(scenario.limits.v_u1, FASTEST, strict=True):
        assert 0.85 * fastest < limit < fastest
    assert scenario.filter.kind == "clip"
    assert {*taken} == {"limits.v_u1", "reference.kind"}
    assert isinstance(scenario.robot.m, Unknown)
    assert any("nobody stated limits.v_u1" in text for text in silent.remarks)
    assert "seen in the log, not your limit" in file.read_text()


@pytest.mark.parametrize("name", ["tau", "gain"])
def test_each_axis_has_its_own_bounds(silent, name):
    both = silent.scenario.filter.intervals(name)

    for own, other, truth in zip(both, both[::-1], FIRST[name], strict=True):
        assert own[0] < truth < own[1]
        assert not other[0] < truth < other[1]
    assert loads_scenario(silent.to_toml()).filter.intervals(name) == both


def test_bounds_of_wheels_hold_both_axes(silent):
    wheels = of_velocities(filter__channels="wheels", robot__l=0.3)

    assert wheels.scenario.filter.kind == "clip"
    (low, _), (_, high) = sorted(silent.scenario.filter.intervals("gain"))
    assert wheels.scenario.filter.gain == (low, high)


def test_what_was_stated_is_written_though_it_is_as_by_default_and_is_not_assumed():
    stated = {"limits.v_u1": [0.3, 0.6], "limits.v_u2": [0.2, 0.5], "robot.m": 50.0}
    found = identify(LOG, base="velocity", overrides=stated)
    written = tomllib.loads(found.to_toml())

    assert written["robot"]["m"] == 50.0
    assert written["limits"]["v_u1"] == [0.3, 0.6]
    assert not {*stated} & {*written["assumed"]}
    assert found.scenario.filter.kind == "clip"


def test_a_filter_is_wider_up_to_twice_the_speeds_of_its_log_and_off_beyond(silent):
    found = of_velocities(limits__v_u1=[1.2, 0.9], limits__v_u2=[0.6, 0.5])

    assert found.scenario.filter.kind == "none"
    (said,) = (text for text in found.remarks if "the filter is off" in text)
    assert "1.2 m/s" in said
    most = float(said.split("at most ")[1].split(" m/s")[0])
    near = of_velocities(limits__v_u1=[most, 0.9], limits__v_u2=[0.1, 0.5])
    assert near.scenario.filter.kind == "clip"
    assert near.bounds.d[0] == pytest.approx(2 * silent.bounds.d[0], rel=0.1)
    wider, (_, most) = (item.scenario.filter.intervals("gain") for item in (near, silent))
    assert wider[0][1] > silent.scenario.filter.intervals("gain")[0][1]
    assert wider[1][1] == pytest.approx(most[1], rel=0.01)
    assert {"filter.gain", "filter.d"} <= {*near.scenario.assumed}
    assert any("beyond the fastest motion of the log" in text for text in near.remarks)


def test_numbers_of_a_filter_that_is_off_are_assumed_and_check_says_so():
    found = of_velocities(limits__v_u1=[1.2, 0.9], limits__v_u2=[0.6, 0.5])
    scenario = loads_scenario(found.to_toml())

    assert {"filter.gain", "filter.d"} <= {*scenario.assumed}
    said = promise(settle(scenario, "kanayama"))
    assert "state filter.gain, filter.d: nobody did" in said
    assert "within assumed bounds" in promise(
        settle(override(scenario, {"filter.kind": "clip"}), "kanayama")
    )


def test_a_filter_that_is_refused_is_off():
    """Readings that are far off for a while make a deviation above the limit."""
    speed = np.array(LOG["v1_measured [m/s]"])
    speed[300:310] += 0.6

    found = of_velocities(LOG | {"v1_measured [m/s]": speed.tolist()})

    assert found.scenario.filter.kind == "none"
    assert any("the filter is off: with these numbers it is refused" in x for x in found.remarks)


def followed(commands):
    """`LOG` with other commands of v, and a base that follows them."""
    sent, v, seen = commands(np.array(LOG["v_command [m/s]"])), 0.0, []
    for k, _ in enumerate(sent):
        seen.append(v)
        v += (sent[max(k - 1, 0)] - v) * -np.expm1(-0.02 / 0.2)
    noise = np.random.default_rng(0).normal(size=len(seen)) * 3e-3
    return LOG | {"v_command [m/s]": sent.tolist(), "v1_measured [m/s]": (seen + noise).tolist()}


def test_a_log_of_one_direction_switches_the_filter_off():
    found = of_velocities(followed(np.abs))

    assert found.scenario.filter.kind == "none"
    assert any("does not show what the base does in the other" in text for text in found.remarks)
    assert {"filter.gain", "filter.d"} <= {*found.scenario.assumed}


def test_a_filter_rests_on_what_is_assumed_between_the_speeds_of_a_log():
    """A log of a single speed in each direction: most of what the filter sends is not in it."""
    found = of_velocities(followed(lambda u: 0.5 * np.sign(u)))

    assert found.scenario.filter.kind == "clip"
    assert sum(text.startswith("v_command was never from") for text in found.remarks) == 2
    assert {"filter.gain", "filter.d"} <= {*found.scenario.assumed}


def offset_log(seed=0):
    """A base that drives by 0.1 m/s and 0.4 rad/s less than it is told."""
    log = steps(FIRST, 24.0, seed)
    commands = np.column_stack([log["v_command [m/s]"], log["omega_command [rad/s]"]])
    rng, v, seen = np.random.default_rng(seed), np.zeros(2), []
    for k, _ in enumerate(commands):
        seen.append(v)
        v = moved(v, commands[max(k - 2, 0)])
    noisy = np.array(seen) + rng.normal(size=(len(seen), 2)) * (0.003, 0.006)
    log |= {
        "v1_measured [m/s]": noisy[:, 0].tolist(),
        "omega_measured [rad/s]": noisy[:, 1].tolist(),
    }
    return log


def moved(v, command):
    acts = np.sign(command) * np.maximum(np.abs(command) - (0.1, 0.4), 0.0)
    return acts + (v - acts) * np.exp(-0.02 / np.array((0.15, 0.1)))


@pytest.mark.slow_but("1.5")
@pytest.mark.parametrize("stated", [None, 1.0, 1.5])
def test_the_base_of_a_log_that_no_loop_explains_keeps_the_limits_of_its_filter(stated):
    log = offset_log()
    seen = of_velocities(log).scenario.limits.v_u1
    limits = {} if stated is None else {"limits__v_u1": [stated * item for item in seen]}
    if stated is not None:
        limits["limits__v_u2"] = [0.7 * stated * item for item in seen]
    scenario = of_velocities(log, **limits).scenario

    assert scenario.filter.kind == "clip"
    for asked in ((9.0, 0.0), (0.0, 9.0), (9.0, 9.0)):
        filtered, v, late = command_filter(scenario), np.zeros(2), [(0.0, 0.0)] * 2
        for k in range(200):
            sign = 1 if k // 40 % 2 == 0 else -1
            late.append(filtered.step((sign * asked[0], sign * asked[1])).command)
            v = moved(v, np.array(late[-3]))
            assert (np.abs(v) <= scenario.limits.v_u1).all()


@pytest.mark.parametrize("rate", [7.0, 20.0, 29.9, 30.0, 33.0, 50.0, 100.0])
@pytest.mark.parametrize("name", VELOCITY)
def test_every_base_that_is_included_can_be_put_on_the_clock_of_a_log(name, rate):
    known = override(load_scenario(name), {"sensor.pose_period": 0.1, "clock.duration": 80.0})
    remarks = []

    bare = bare_scenario(known, SimpleNamespace(period=1 / rate), remarks)

    assert bare.base.delay == 0.0
    ratio = bare.sensor.pose_period / bare.clock.control
    assert ratio == pytest.approx(round(ratio))
    assert math.isclose(bare.sensor.pose_period, 0.1, abs_tol=1 / rate)
    told = any("sensor.pose_period = 0.1 s becomes" in text for text in remarks)
    assert told is (abs(bare.sensor.pose_period - 0.1) > 1e-9)


def test_known_guards_and_delays_do_not_stop_a_log_of_another_clock():
    known = override(paper(), {
        "guard.delay": [0.0, 0.01], "actuator.delay": 0.007, "sensor.pose_delay": 0.03,
        "encoder.counts": 2048, "encoder.window": 0.05,
    })  # fmt: skip

    bare = bare_scenario(known, SimpleNamespace(period=0.0301), remarks := [])

    assert bare.actuator.delay == 0.0
    assert bare.value("encoder.window")[0] == pytest.approx(0.0602)
    assert len(remarks) == 2


def test_wheels_of_the_paper_are_not_taken_for_known(driven, tmp_path):
    (tmp_path / "known.toml").write_text("[limits]\nv_u1 = [0.5, 1.0]\nv_u2 = [0.4, 0.8]\n")
    log = log_of(driven, 0)

    with pytest.raises(LogError, match=r"robot\.r and robot\.l must be known"):
        identify(log, known=tmp_path / "known.toml", overrides={"encoder.counts": TRUTH.counts})


def test_numbers_of_a_preset_that_a_file_extends_are_used(tmp_path):
    known = tmp_path / "known.toml"
    known.write_text(
        'extends = "turtlebot3-burger"\n[limits]\nv_u1 = [0.3, 0.6]\nv_u2 = [0.2, 0.5]\n'
    )

    found = identify(LOG, base="velocity", known=known)
    again = tmp_path / "found.toml"
    again.write_text(found.to_toml())

    assert found.scenario.robot.r == load_scenario("turtlebot3-burger").robot.r
    assert not {"robot.m", "robot.r"} & {*found.scenario.assumed}
    assert "limits.v_u1" not in found.scenario.assumed
    assert load_scenario(again).assumed == found.scenario.assumed
    assert identify(LOG, base="velocity", known=again).scenario.limits == found.scenario.limits


def test_limits_of_an_earlier_log_are_not_stated_ones(silent, tmp_path):
    (tmp_path / "mine.toml").write_text(silent.to_toml())
    faster = {key: [(1 + (key != "t [s]")) * item for item in LOG[key]] for key in LOG}

    found = identify(faster, base="velocity", known=tmp_path / "mine.toml")

    assert found.scenario.limits.v_u1[0] > 1.5 * silent.scenario.limits.v_u1[0]
    assert found.scenario.filter.kind == "clip"


@pytest.mark.parametrize("speed", [0.05, 0.3, 0.9, 2.0])
def test_a_log_completes_a_scenario_whatever_its_limits(speed, tmp_path):
    """One begun by `new` states v_u1 alone."""
    limits = [speed, 2 * speed]
    items = [Found("limits.v_u1", tuple(limits), "f: x", Rank.CONTROLLER)]
    (tmp_path / "mine.toml").write_text(new_scenario(merged(items), "velocity", "mine").text)

    found = identify(LOG, base="velocity", known=tmp_path / "mine.toml")

    assert "limits" not in tomllib.loads(found.to_toml())
    assert [*loads_scenario(found.to_toml()).limits.v_u1] == limits
    assert not {"base.tau", "base.delay", "limits.v_u1"} & {*found.scenario.assumed}


def test_a_guard_keeps_to_the_speeds_and_torques_of_the_log(driven, found):
    """`found` knows wheels and counts alone."""
    scenario, log = found.scenario, log_of(driven, 0)

    assumed = {"limits.v_u1", "actuator.tau_max", "reference.kind"}
    assert assumed == {*scenario.assumed}
    most = [max(map(abs, log[f"tau_{side} [N.m]"])) for side in ("right", "left")]
    assert 0.9 * min(most) < scenario.actuator.tau_max <= min(most)
    assert scenario.guard.enabled
    assert scenario.guard.dbar == found.bounds.dbar
    written = tomllib.loads(found.to_toml())
    assert {*written["robot"]} == {"m", "I", "mu", "r", "l"}


@pytest.mark.slow
def test_what_neither_log_nor_user_tells_is_left_out_of_the_file(tmp_path):
    """A drive straight ahead says nothing about the inertia and the limit of turning."""
    rng, v, rows = np.random.default_rng(0), 0.0, []
    for t in np.arange(0.0, 20.0, 0.01):
        torque = 0.6 + 0.9 * np.sin(2 * t) + 0.5 * np.sign(np.sin(5.3 * t))
        rows.append((t, v + 1e-3 * rng.uniform(-1, 1), 5e-4 * rng.uniform(-1, 1), torque, torque))
        v += 0.01 * (2 * torque / 0.1 - 4 * np.tanh(v / 0.01) - 12 * v + 0.3 * rng.normal()) / 20
    names = ("t [s]", "v1_measured [m/s]", "omega_measured [rad/s]", "tau_right [N.m]")
    names = (*names, "tau_left [N.m]")
    log = dict(zip(names, np.array(rows).T.tolist(), strict=True))
    wheels = {"robot.r": 0.1, "robot.l": 0.2}
    found = identify(log, overrides=wheels)
    known = identify(log, overrides={**wheels, "robot.I": 0.7, "limits.v_u1": [1, 2]})

    assert {"robot.I", "limits.v_u1"} <= {*found.missing}
    assert any("missing" in text and "robot.I [kg.m2]" in text for text in found.remarks)
    (tmp_path / "mine.toml").write_text(found.to_toml())
    with pytest.raises(ScenarioError, match=r"missing: .*robot\.I .*limits\.v_u1"):
        load_scenario(tmp_path / "mine.toml")
    assert not {"robot.I", "limits.v_u1"} & {*known.missing}
    assert known.scenario.robot.I == 0.7


@pytest.mark.parametrize("far, enabled", [(1.0, True), (1.5, True), (2.1, False)])
def test_limits_beyond_the_log_widen_a_guard_or_switch_it_off(found, far, enabled):
    values = {name: item.value for name, item in found.parameters.items()}
    base = override(found.scenario, {"guard.enabled": False})
    limits = {"limits.v_u1": [far * item for item in base.limits.v_u1]}
    remarks = []

    made = identifying._scenario(
        "log", override(base, limits), values, found.bounds, (far, far), remarks
    )

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
    text = "[robot]\nr = 0.05\nl = 0.12\n[base]\ndelay = 0.5\n[limits]\nclip = 1e-5\n"
    known.write_text(text)
    found = identify(LOG, base="velocity", known=known)
    (out / "mine.toml").write_text(found.to_toml(out))

    scenario, table = load_scenario(out / "mine.toml"), tomllib.loads(found.to_toml(out))

    assert replace(scenario, name="identified") == found.scenario
    assert table["extends"] == "../robot/data sheet.toml"
    assert not {"robot", "initial", "sensor"} & {*table}
    assert {*table["limits"]} == {"v_u1"}
    assert "limits.v_u1" in scenario.assumed
    interval = r"tau1 0\.\d+ to 0\.\d+ s, determined; tau2 .*; from log, 12 s"
    assert re.search(rf"tau = \[0\.\d{{1,4}}, 0\.\d{{1,4}}\] .*{interval}", found.to_toml())


@pytest.mark.parametrize(
    "value, digits", [(1234.56, (1234.0, 1235.0)), (-0.0123456, (-0.01235, -0.01234)),
                          (0.25, (0.25, 0.25)), (0.0, (0.0, 0.0)), (math.inf, (math.inf,) * 2)]
)  # fmt: skip
def test_intervals_are_rounded_outward_to_four_digits(value, digits):
    assert outward(value, value) == digits


def test_short_logs_count_as_one_and_rest_between():
    """Six short logs: at rest, then a step of both commands."""
    whole, rng, several = steps(FIRST, 2.5), np.random.default_rng(4), []
    for _ in range(6):
        log = {"t [s]": whole["t [s]"]}
        for axis, (name, sent) in enumerate(
            (
                ("v1_measured [m/s]", "v_command [m/s]"),
                ("omega_measured [rad/s]", "omega_command [rad/s]"),
            )
        ):
            level = rng.choice([-1, 1]) * rng.uniform(0.2, 0.5)
            t = np.array(log["t [s]"])
            rises = np.maximum(t - 0.5 - FIRST["delay"], 0.0) / FIRST["tau"][axis]
            log[sent] = (level * (t >= 0.5)).tolist()
            speed = FIRST["gain"][axis] * level * -np.expm1(-rises)
            log[name] = (speed + 0.002 * rng.normal(size=len(t))).tolist()
        several.append(log)
    found = identify(several, base="velocity")

    for axis in (1, 2):
        for name in ("gain", "tau", "delay"):
            item, true = found.parameters[f"{name}{axis}"], FIRST[name]
            true = true if name == "delay" else true[axis - 1]
            assert item.verdict in ("determined", "roughly"), name
            assert item.value == pytest.approx(true, rel=0.05, abs=0.002), name
    one = identify(several[:1], base="velocity")
    assert one.scenario.filter.kind == "none"
    assert one.to_toml()
    with pytest.raises(LogError, match="no column is in all"):
        identify([several[0], {"t [s]": [0.0, 1.0], "v1 [m/s]": [0.0, 0.0],
                               "omega [rad/s]": [0.0, 0.0]}], base="velocity")  # fmt: skip


@pytest.mark.parametrize("commanded", [(0.0, 0.0), (0.3, 0.5)])
def test_constant_columns_determine_nothing_and_are_no_error(commanded, tmp_path):
    count, (v, omega) = 1000, commanded
    columns = {"v_command [m/s]": v, "omega_command [rad/s]": omega, "v1 [m/s]": v,
               "omega [rad/s]": omega}  # fmt: skip
    log = {"t [s]": [0.02 * k for k in range(count)],
           **{name: [value] * count for name, value in columns.items()}}  # fmt: skip

    found = of_velocities(log, limits__v_u1=[1.0, 2.0])

    assert {*found.parameters} == {
        f"{n}{axis}" for n in ("gain", "tau", "delay") for axis in (1, 2)
    }
    assert {item.verdict for item in found.parameters.values()} == {"undetermined"}
    assert any("Change both commands by steps" in text for text in found.remarks)
    assert found.traces().measured.shape == (count, 2)
    file = tmp_path / "mine.toml"
    file.write_text(found.to_toml())
    written = tomllib.loads(file.read_text())
    assert load_scenario(file).filter.kind == "none"
    assert written["base"] == {"kind": "velocity"}
    assert "# model_delay: the log shows none" in nav2_of(found)


@pytest.mark.slow
def test_constant_torques_determine_nothing_and_are_no_error(driven):
    log = log_of(driven, 0)
    still = {name: [0.5] * len(column) if name.startswith("tau") else list(column)
             for name, column in log.items()}  # fmt: skip

    found = identify(still, overrides=KNOWN)

    assert {item.verdict for item in found.parameters.values()} == {"undetermined"}
    assert not found.scenario.guard.enabled
    assert any("determines nothing" in text for text in found.remarks)


def test_a_result_that_one_file_cannot_hold_writes_none(silent, tmp_path, monkeypatch, capsys):
    torques = replace(silent, bounds=SimpleNamespace(section="guard", sentence="seen"))
    monkeypatch.setattr("wmr_ctrl.identification.identify", lambda *_, **__: torques)

    with pytest.raises(SystemExit, match="2"):
        root.main(["identify", "log.csv", "--out", str(tmp_path / "mine.toml"),
                   "--nav2", str(tmp_path / "nav2.yaml")])  # fmt: skip

    assert "this base takes torques" in capsys.readouterr().err.replace("\n  ", " ")
    assert not [*tmp_path.iterdir()]


def test_parameters_of_nav2_are_numbers_of_one_type(silent):
    parameters = yaml.safe_load(nav2_of(silent))

    follow = parameters["controller_server"]["ros__parameters"]["FollowPath"]
    smoother = parameters["velocity_smoother"]["ros__parameters"]
    assert follow == {"model_delay": pytest.approx(FIRST["delay"], abs=2e-3)}
    assert smoother == {"deadband_velocity": [0.0, 0.0, 0.0]}
    assert "# max_accel: the log shows none" in nav2_of(silent)
    ramped = replace(silent, parameters=silent.parameters | {
        name: silent.parameters["gain1"]._replace(value=value)
        for name, value in {"accel1": 1.0, "accel2": 2.0, "decel1": 3.0, "decel2": 1.5}.items()
    })  # fmt: skip
    smoother = yaml.safe_load(nav2_of(ramped))["velocity_smoother"]["ros__parameters"]
    assert smoother["max_accel"] == [1.0, 0.0, 2.0]
    assert smoother["max_decel"] == [-3.0, 0.0, -1.5]
    assert {type(x) for x in smoother["max_accel"]} == {float}
