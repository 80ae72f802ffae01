"""The Simulink kit, as far as it can be tried without Simulink: see the headers of the mocks."""

import re
import subprocess
from dataclasses import replace
from operator import ne
from pathlib import Path

import casadi as ca
import pytest

from tests.commands import finished
from tests.compilers import where
from wmr_ctrl.api import export_fmu
from wmr_ctrl.codegen.package import c_name, package_files, packaged
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.signals import LARGEST, POSE, REFERENCE, VELOCITY, Signal
from wmr_ctrl.export.simulink import kit_files
from wmr_ctrl.export.simulink.kit import _parameter
from wmr_ctrl.world.model.system import Port
from wmr_ctrl.world.scenario import load_scenario, override

HERE = Path(__file__).parent
SCENARIO = load_scenario("paper-simulation")
SAFE = load_scenario("safe-simulation")
OTHER = {
    "limits.v_u1": [1.1, 1.7], "limits.v_u2": [0.7, 1.2], "actuator.tau_max": 30.0,
    "robot.r": 0.11, "robot.l": 0.27, "model.m": 55.0, "model.I": 6.0,
    "guard.mass_margin": 0.2, "gains.kinematics.k": [8.0, 4.0, 3.5],
}  # fmt: skip
STRICT = ("-Wall", "-Wextra", "-Werror", "-O1", "-ffp-contract=off")


def written(folder, law, scenario=SCENARIO, asked=None):
    """Write the kit, with vectors and a dialog of ``asked``, else of the same scenario."""
    for name, text in kit_files(law, scenario).items():
        (folder / name).write_text(text, "utf-8")
    asked = asked or scenario
    vectors = package_files(law, asked)["vectors.h"]
    (folder / "vectors.h").write_text(vectors, "utf-8")
    values = [port.value for port in tuned(law, asked)]
    numbers = ", ".join(repr(value) for port in values for value in port).replace("inf", "HUGE_VAL")
    sizes = ", ".join(str(len(port)) for port in values)
    (folder / "dialog.h").write_text(
        f"#define MOCK_DIALOG {len(values)}\n"
        f"static const real_T mock_dialog[] = {{{numbers}}};\n"
        f"static const size_t mock_sizes[] = {{{sizes}}};\n",
        "utf-8",
    )


def tuned(law, scenario):
    """The law's parameters except its period."""
    ports = packaged(settle(scenario, law)).params
    return [port for port in ports if port.signal.name != "clock.control"]


def played(folder, law, language=("gcc", "-std=c99"), *options, ends=0):
    """What a play of the S-function prints, in lines, if it ends with that status."""
    sources = [f"sfun_wmr_{law}.c", f"wmr_{law}.c"]
    compiler, dialect = language
    command = [where(compiler), dialect, *STRICT, *options, f"-I{HERE / 'mock'}", "-I.", *sources]
    finished([*command, "-o", "play", "-lm"], cwd=folder)
    done = subprocess.run([folder / "play"], capture_output=True, text=True, check=False)
    assert done.returncode == ends, (done.returncode, done.stdout)
    return done.stdout.splitlines()


@pytest.mark.parametrize(
    "law, language",
    [("prox", ("gcc", "-std=c99")), ("pursuit", ("g++", "-xc++"))],
    ids=["prox-c", "pursuit-c++"],
)
@pytest.mark.slow
def test_the_s_function_plays_the_laws_vectors(tmp_path, law, language):
    """Memory moves in mdlUpdate alone, and a run may be saved; no finite input ends in an error."""
    written(tmp_path, law)
    first, *rest = played(tmp_path, law, language)
    period, worst, count = map(float, first.split())
    assert period == SCENARIO.clock.control
    assert worst < 1e-12
    assert count == 78
    assert rest[:2] == ["memory 1 1", "next 0 1"]


@pytest.mark.parametrize("law, guarded", [("pid", False), ("pursuit", True)])
@pytest.mark.slow
def test_a_number_in_the_dialog_is_that_number_in_an_export(tmp_path, law, guarded):
    """Limits, gains, model and guard of a new scenario in a kit of the old: the new vectors."""
    base = override(SAFE, {"guard.enabled": guarded})
    other = override(base, OTHER)
    before, after = ([port.value for port in tuned(law, each)] for each in (base, other))
    assert sum(map(ne, before, after)) >= 4
    for name, asked, kit in (("new", other, other), ("tuned", other, base)):
        folder = tmp_path / name
        folder.mkdir()
        written(folder, law, kit, asked)
        assert float(played(folder, law)[0].split()[1]) < 1e-12
    (tmp_path / "teeth").mkdir()
    written(tmp_path / "teeth", law, base)
    vectors = package_files(law, other)["vectors.h"]
    (tmp_path / "teeth" / "vectors.h").write_text(vectors, "utf-8")
    assert float(played(tmp_path / "teeth", law)[0].split()[1]) > 1e-3


@pytest.mark.slow
def test_the_dialog_refuses_by_name(tmp_path):
    """Not a number, one number too many, a text: each with the name; the right one is taken."""
    written(tmp_path, "mb", SAFE)
    lines = played(tmp_path, "mb", ("gcc", "-std=c99"), "-DMOCK_OLD")[3:]
    ports = tuned("mb", SAFE)
    assert len(lines) == 4 * len(ports)
    for port, group in zip(ports, zip(*[iter(lines)] * 4, strict=True), strict=True):
        assert all(line.startswith(f"{c_name(port.signal)}: ") for line in group[:3])
        assert group[3] == "taken"
    assert "limits_v_u2: 2 numbers, at least 1e-12." in lines


@pytest.mark.slow
def test_limits_in_the_wrong_order_are_refused(tmp_path):
    written(tmp_path, "mb", SAFE)
    dialog = tmp_path / "dialog.h"
    ports = tuned("mb", SAFE)
    at = sum(p.signal.size for p in ports[: [p.signal.name for p in ports].index("limits.v_u2")])
    head, numbers, tail = re.split(r"\{(.*?)\}", dialog.read_text("utf-8"), maxsplit=1)
    values = numbers.split(", ")
    values[at] = "5.0"
    dialog.write_text(f"{head}{{{', '.join(values)}}}{tail}", "utf-8")
    (told,) = played(tmp_path, "mb", ends=5)
    assert told == "limits_v_u2: below limits_v_u1 in each of the two numbers."


@pytest.mark.parametrize("controller", ["sfunction", "fmu"])
@pytest.mark.slow_but("sfunction")
def test_the_script_wires_ports_of_one_name(tmp_path, controller):
    written(tmp_path, "nn")
    call = f"addpath('{HERE / 'stubs'}'); wmr_loop('m', '.', '{controller}')"
    done = finished([where("octave-cli"), "-qf", "--eval", call], cwd=tmp_path)
    shown = (*REFERENCE, *POSE, *VELOCITY)
    wanted = {f"reference/{k} controller/{k}" for k in range(1, len(REFERENCE) + 1)}
    wanted |= {f"plant/{k} controller/{k + 7}" for k in range(1, len(shown) - 6)}
    wanted |= {"controller/1 plant/1", "controller/2 plant/2"}
    zero = ("noise_right", "noise_left", "thrust", "moment")
    wanted |= {f"no_{name}/1 plant/{k}" for k, name in enumerate(zero, start=3)}
    lines = done.stdout.split("\n")[:-1]
    fields = [line.split() for line in lines if line.startswith("FIELD")]
    given = [line.split(None, 2) for line in lines if line.startswith("PARAMETERS")]
    assert sorted(line for line in lines if "/" in line) == sorted(wanted)
    ports = tuned("nn", SCENARIO) if controller == "sfunction" else []
    assert [item[1] for item in fields] == [c_name(port.signal) for port in ports]
    for field, port in zip(fields, ports, strict=True):
        assert tuple(map(float, field[2:])) == port.value
    names = ", ".join(c_name(port.signal) for port in ports)
    assert given == ([["PARAMETERS", "sfun_wmr_nn", names]] if ports else [])


@pytest.mark.parametrize("law", ["mb", "nn"])
@pytest.mark.slow_but("mb")
def test_the_c_caller_has_the_structs_of_the_package(tmp_path, law):
    """Constants and memory have the header's fields and the law's numbers, wires its arguments."""
    written(tmp_path, law)
    done = finished(
        [where("octave-cli"), "-qf", "--eval", f"addpath('{HERE / 'stubs'}'); wmr_ccaller('m')"],
        cwd=tmp_path,
    )
    lines = done.stdout.split("\n")[:-1]
    header = (tmp_path / f"wmr_{law}.h").read_text("utf-8")
    system = packaged(settle(SCENARIO, law))
    for name, ports in (("parameters", system.params), ("state", system.state)):
        body = re.search(rf"typedef struct \{{([^}}]*)\}} wmr_{law}_{name};", header)[1]
        found = re.findall(r"wmr_real (\w+)(?:\[(\d+)\])?;", body)
        key = "memory" if name == "state" else name
        (line,) = (line for line in lines if line.startswith(f"WORKSPACE {key} "))
        fields = [field.split(":") for field in line.split()[2:]]
        assert [(field, len(values)) for field, *values in fields] == [
            (field, int(size or 1)) for field, size in found
        ]
        for (_, *values), port in zip(fields, ports, strict=bool(ports)):
            assert tuple(map(float, values)) == port.value
    order = re.search(rf"int wmr_{law}_step\((.*?)\);", header, flags=re.S)[1]
    assert re.findall(r"\*(\w+)", order) == ["parameters", "state", "inputs", "outputs"]
    asked = [signal.name for signal in (*REFERENCE, *POSE, *VELOCITY)]
    wanted = {f"{name}/1 inputs/{k}" for k, name in enumerate(asked, start=1)}
    wanted |= {"parameters/1 law/1", "memory/1 law/2", "inputs/1 law/3", "law/1 refused/1"}
    wanted |= {"law/2 memory/1", "law/3 torques/1"}
    wanted |= {"torques/1 tau_right/1", "torques/2 tau_left/1"}
    assert {line for line in lines if "/" in line} == wanted


@pytest.mark.parametrize("name", ["a 'quoted' one", "two\nend", "two\r*/ int x;", 'a "b" c'])
@pytest.mark.slow_but("two\\r*/ int x;")
def test_a_name_ends_neither_comment_nor_text(name):
    """The scenario's name is in comments only, on one line of each."""
    plain, named = (kit_files("mb", replace(SCENARIO, name=each)) for each in ("wmr", name))
    for file in ("sfun_wmr_mb.c", "wmr_block.m", "wmr_loop.m", "wmr_ccaller.m", "README.md"):
        assert len(named[file].splitlines()) == len(plain[file].splitlines())
        for one, other in zip(plain[file].splitlines(), named[file].splitlines(), strict=True):
            assert one == other or one.startswith("%") or file == "README.md"
    assert named["sfun_wmr_mb.c"] == plain["sfun_wmr_mb.c"]


def test_the_kit_is_written_and_says_what_was_tried(tmp_path):
    paths = export_fmu("simulink", law="mb", scenario=SCENARIO, out=tmp_path / "kit")
    names = {path.name for path in paths}
    assert names == {
        "sfun_wmr_mb.c", "wmr_block.m", "wmr_loop.m", "wmr_ccaller.m", "README.md",
        "wmr_mb.c", "wmr_mb.h", "arithmetic.h",
    }  # fmt: skip
    assert "not tried" in (tmp_path / "kit" / "README.md").read_text("utf-8")


def test_what_the_kit_cannot_hold_is_refused():
    with pytest.raises(ArgumentError, match="lag"):
        kit_files("mb", override(SCENARIO, {"actuator.lag": 0.02}))


def test_a_number_without_ends_may_be_any():
    """Ends beyond what any number of ours may be are none."""
    port = Port(Signal("some.gain", "1", "a gain"), ca.SX.sym("g"), (2.0,))

    assert _parameter(port, None)["wanted"] == "a number"
    assert _parameter(port, (0.0, LARGEST))["wanted"] == "a number, at least 0"
    assert _parameter(port, (-3.0, 4.0))["wanted"] == "a number, at least -3, at most 4"
