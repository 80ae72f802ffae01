"""Missing keys are requested together; unknown values change no motion; the rest is derived."""

import re
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from tests.papers_robot import HEAD, paper
from tests.tables import cases, changes
from wmr_ctrl import simulate
from wmr_ctrl.control.controller import lacking
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.core.fields.unstated import Unstated, unknown
from wmr_ctrl.world.references import REFERENCES
from wmr_ctrl.world.references.kind import reference_bounds
from wmr_ctrl.world.scenario import (
    Scenario,
    from_dict,
    inherited,
    load_scenario,
    loads_scenario,
    override,
    sections,
)
from wmr_ctrl.world.scenario.toml_io import to_toml
from wmr_ctrl.world.scenario.unstated import (
    KIND,
    guessed_keys,
    missing_keys,
    missing_text,
    unknown_keys,
)

ROBOT = {"m": 12.0, "I": 0.6, "mu": 0.05, "r": 0.08, "l": 0.2}
LIMITS = {"v_u1": [0.6, 1.2]}
CIRCLE = {"kind": "circle", "radius": 1.0, "rate": 0.25}
TORQUE = {"robot": ROBOT, "limits": LIMITS, "reference": CIRCLE}
VELOCITY = {"base": {"kind": "velocity"}, "limits": LIMITS, "reference": CIRCLE}
REQUIRED = ("limits.v_u1", "reference.kind", *(f"robot.{name}" for name in ROBOT))


def test_all_missing_keys_stand_in_one_message_with_what_else_is_wrong():
    with pytest.raises(ScenarioError) as nothing:
        Scenario()
    with pytest.raises(ScenarioError) as wrong:
        loads_scenario("[robot]\nm = -3\nweight = 4\n[limit]\nv = 1\n")

    assert all(re.search(rf"{key}( \[.*\])?: \w+", str(nothing.value)) for key in REQUIRED)
    assert all(
        part in str(wrong.value) for part in ("robot.m = -3", "robot.weight", "limit is not")
    )
    assert all(key in str(wrong.value) for key in REQUIRED if key != "robot.m")
    assert "robot.m [kg]" not in str(wrong.value)


def test_a_contradicting_key_is_not_called_missing():
    with pytest.raises(ScenarioError, match=r"v_u2\[1\] = 0.7 must be below") as error:
        from_dict({**TORQUE, "limits": {**LIMITS, "v_u2": [0.7, 1.0]}})

    assert "missing" not in str(error.value)


READ = """
    limits.clip = 0.001 | -
    encoder.counts = 1024 | r l
    filter.kind = clip; filter.channels = wheels | l
    base.loop = pi | m I mu r l
    base.w_max = 9.0 | r l
    disturbance.push = [1.0, 0.1] | m I mu r l
    actuator.tau_max = 2.0 | m I mu r l
"""


@pytest.mark.parametrize("text, needed", cases(READ))
def test_a_velocity_base_needs_only_keys_that_are_read(text, needed):
    base = from_dict(VELOCITY)
    with pytest.raises(ScenarioError) if needed != "-" else nullcontext() as missing:
        override(base, changes(text))
    said = str(missing.value) if needed != "-" else ""

    assert {name for name in ROBOT if f"robot.{name} [" in said} == {*needed.split()} - {"-"}


@pytest.mark.parametrize("law", ["kanayama", "pursuit"])
def test_no_motion_depends_on_a_placeholder(law):
    """To the bit if the placeholder is a power of two, which causes no rounding."""
    scenario = override(
        from_dict(VELOCITY), {"clock.duration": 3.0, "initial.pose": [0.1, -0.2, -1]}
    )
    others = {
        name: unknown(factor) for name, factor in zip("mIrl", (4.0, 0.25, 0.5, 2.0), strict=True)
    }
    other = replace(scenario, robot=replace(scenario.robot, **others))
    first, second = (simulate(item, law) for item in (scenario, other))

    assert lacking(scenario, law) == ()
    for name in ("x", "y", "theta", "v1", "omega"):
        assert np.array_equal(first[name], second[name])


def test_unknown_values_are_not_shown_as_known():
    scenario = from_dict(VELOCITY)
    text = to_toml(scenario)

    assert "\n# m = ..." in text
    assert "\n# v_u2 = ..." in text
    assert "not stated" in scenario._repr_html_()
    assert loads_scenario(text, scenario.name) == scenario


def test_a_file_that_lacks_keys_is_a_base_for_others(tmp_path):
    (tmp_path / "part.toml").write_text("[robot]\nm = 12.0\nI = 0.6\n[limits]\nv_u2 = [0.3, 0.4]\n")
    rest = "[robot]\nmu = 0.05\nr = 0.08\nl = 0.2\n[limits]\nv_u1 = [0.6, 1.2]\n"
    whole = f'extends = "part.toml"\n{rest}[reference]\nkind = "line"\n'
    (tmp_path / "whole.toml").write_text(whole)

    assert load_scenario(tmp_path / "whole.toml").robot.m == 12.0
    with pytest.raises(ScenarioError, match=r"^These keys are missing: robot\.mu .*limits\.v_u1"):
        load_scenario(tmp_path / "part.toml")


@pytest.mark.parametrize("kind", REFERENCES)
@pytest.mark.parametrize("limits", [(0.6, 1.2), (0.02, 3.0), (3.0, 0.3)])
def test_a_path_that_nobody_sizes_leaves_the_limits_room(kind, limits):
    own = {"points": [[0, 0], [1, 0], [2, 1]]} if kind == "waypoints" else {}
    known = dict(REFERENCES[kind].section.QUANTITIES)
    sizes = {"radius": 0.5, "size": 0.5, "side": 1.0, "corner": 0.2, "speed": 0.01}
    for more in ({}, *({name: size} for name, size in sizes.items() if name in known)):
        path = {"kind": kind, **own, **more}
        made = from_dict({**VELOCITY, "limits": {"v_u1": limits}, "reference": path})
        _, fastest, turning = reference_bounds(made)
        assert fastest < 0.501 * limits[0]
        assert turning < 0.51 * limits[1]
        assert all(getattr(made.reference, name) == value for name, value in more.items())


def test_missing_values_are_derived():
    scenario = from_dict(TORQUE)
    path = {"kind": "waypoints", "points": [[0, 0], [1, 0], [2, 1]]}
    along = from_dict({**TORQUE, "reference": path})

    assert scenario.limits.v_u2 == pytest.approx((0.51, 1.02))
    assert scenario.metrics.tolerance == pytest.approx(0.04)
    assert from_dict(VELOCITY).metrics.tolerance == pytest.approx(0.03)
    assert scenario.initial.pose == pytest.approx((0.0, 0.0, -np.pi / 2))
    assert scenario.initial.velocity == pytest.approx((0.25, 0.25))
    assert scenario.clock.duration == 60.0
    rest = along.clock.duration - along.reference.arrival
    assert 2.0 - 1e-9 <= rest < 2.0 + along.clock.control
    assert (scenario.disturbance.std, scenario.changes) == (0.0, ())
    halved = override(scenario, {"limits.v_u1": [0.3, 0.6]})
    assert halved.limits.v_u2 == pytest.approx((0.255, 0.51))
    assert isinstance(halved.limits.v_u2, Unstated)


def test_missing_unknown_and_guessed_keys_are_listed():
    base = from_dict(VELOCITY)

    assert missing_keys(paper()) == unknown_keys(paper()) == guessed_keys(paper()) == ()
    assert set(unknown_keys(base)) >= {"robot.m", "robot.I"}
    assert guessed_keys(base) == ("base.tau",)
    one = missing_text(("robot.m",), sections())
    assert one.startswith("A key is missing: robot.m [kg]: ")
    assert "state them, or extend" in missing_text(("robot.m", "reference.kind"), sections())


def keys(path, overrides=None):
    return [item.key for item in inherited(load_scenario(path, overrides))]


LIMITED = f"""assumed = ["limits.v_u1", "robot.mu"]
{HEAD}[limits]
v_u1 = [0.9, 1.4]
[robot]
mu = 0.0
"""


def test_what_a_file_calls_assumed_is_listed_until_somebody_states_it(tmp_path):
    mine = tmp_path / "mine.toml"
    mine.write_text(LIMITED)
    child = tmp_path / "child.toml"

    assert keys(mine) == ["limits.v_u1", "robot.mu"]
    stated = load_scenario(mine, {"limits.v_u1[1]": 0.95})
    assert stated.assumed == ("robot.mu",)
    assert override(load_scenario(mine), {"robot": {"mu": 0.1}}).assumed == ("limits.v_u1",)
    child.write_text('extends = "mine.toml"\n[limits]\nv_u1 = [1.0, 1.5]\n')
    assert keys(child) == ["robot.mu"]
    child.write_text(f'extends = "mine.toml"\nassumed = ["{KIND}"]\n[reference]\nkind = "line"\n')
    assert keys(child) == ["limits.v_u1", "robot.mu", KIND]


@pytest.mark.parametrize("raw", ['"robot.m"', '["robot.mass"]', '["robot"]', "[1]", "3"])
def test_what_is_assumed_is_a_list_of_keys(raw):
    with pytest.raises(ScenarioError, match="assumed"):
        loads_scenario(f"assumed = {raw}\n{HEAD}")
