"""The Simulink kit, as far as it can be tried without Simulink: see the headers of the mocks."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.matrix import headed, turns
from wmr_ctrl.api import export_fmu
from wmr_ctrl.codegen.package import package_files
from wmr_ctrl.errors import ArgumentError
from wmr_ctrl.laws import LAWS
from wmr_ctrl.scenario import load_scenario, override
from wmr_ctrl.signals import POSE, REFERENCE, VELOCITY
from wmr_ctrl.simulink import kit_files

HERE = Path(__file__).parent
SCENARIO = load_scenario("paper-simulation")
STRICT = ("-Wall", "-Wextra", "-Werror", "-O1", "-ffp-contract=off")


def tool(name):
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"NOT RUN: {name} is not there")
    return found


def written(folder, law, scenario=SCENARIO):
    for name, text in kit_files(law, scenario).items():
        (folder / name).write_text(text, encoding="utf-8")
    vectors = package_files(law, scenario)["vectors.h"]
    (folder / "vectors.h").write_text(vectors, encoding="utf-8")


@pytest.mark.parametrize(
    ("law", "language"),
    turns(headed("prox", LAWS), (("gcc", "-std=c99"), ("g++", "-xc++"))),
)
def test_the_s_function_plays_the_laws_vectors(tmp_path, law, language):
    """Memory moves in mdlUpdate alone; what is not finite ends the simulation by an error."""
    written(tmp_path, law)
    sources = [f"sfun_wmr_{law}.c", f"wmr_{law}.c"]
    command = [tool(language[0]), language[1], *STRICT, f"-I{HERE / 'mock'}", "-I.", *sources]
    made = subprocess.run(
        [*command, "-o", "play", "-lm"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert made.returncode == 0, made.stderr[-2000:]
    done = subprocess.run([tmp_path / "play"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    period, worst, count = map(float, done.stdout.split())
    assert period == SCENARIO.clock.control
    assert worst < 1e-12
    assert count > 20


@pytest.mark.parametrize("controller", ["sfunction", "fmu"])
def test_the_script_wires_ports_of_one_name(tmp_path, controller):
    written(tmp_path, "nn")
    call = f"addpath('{HERE / 'stubs'}'); wmr_loop('m', '.', '{controller}')"
    done = subprocess.run(
        [tool("octave-cli"), "-qf", "--eval", call],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    shown = (*REFERENCE, *POSE, *VELOCITY)
    wanted = {f"reference/{k} controller/{k}" for k in range(1, len(REFERENCE) + 1)}
    wanted |= {f"plant/{k} controller/{k + 7}" for k in range(1, len(shown) - 6)}
    wanted |= {"controller/1 plant/1", "controller/2 plant/2"}
    zero = ("noise_right", "noise_left", "thrust", "moment")
    wanted |= {f"no_{name}/1 plant/{k}" for k, name in enumerate(zero, start=3)}
    lines = done.stdout.split("\n")[:-1]
    assert sorted(lines) == sorted(wanted)


def test_the_kit_is_written_and_says_what_was_tried(tmp_path):
    paths = export_fmu("simulink", law="mb", scenario=SCENARIO, out=tmp_path / "kit")
    names = {path.name for path in paths}
    assert names == {
        "sfun_wmr_mb.c", "wmr_loop.m", "README.md", "wmr_mb.c", "wmr_mb.h", "arithmetic.h",
    }  # fmt: skip
    assert "not tried" in (tmp_path / "kit" / "README.md").read_text(encoding="utf-8")


def test_what_the_kit_cannot_hold_is_refused():
    with pytest.raises(ArgumentError, match="lag"):
        kit_files("mb", override(SCENARIO, {"actuator.lag": 0.02}))
