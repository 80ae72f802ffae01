"""The Simulink kit, as far as it can be tried without Simulink: see the headers of the mocks."""

import re
from operator import ne
from pathlib import Path

import casadi as ca
import pytest

from tests.commands import finished
from tests.compilers import where
from tests.tables import changes
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
OTHER = changes("""
    limits = {v_u1 = [1.1, 1.7], v_u2 = [0.7, 1.2]}
    actuator.tau_max = 30.0
    robot = {r = 0.11, l = 0.27}
    model = {m = 55.0, I = 6.0}
    guard.mass_margin = 0.2
    gains.kinematics.k = [8.0, 4.0, 3.5]
""")
STRICT = ("-Wall", "-Wextra", "-Werror", "-O1", "-ffp-contract=off")


def written(folder, law, scenario=SCENARIO, asked=None):
    """Write the kit, with vectors and a dialog of ``asked``, else of the same scenario."""
    asked = asked or scenario
    values = [port.value for port in tuned(law, asked)]
    numbers = ", ".join(repr(value) for port in values for value in port).replace("inf", "HUGE_VAL")
    sizes = ", ".join(str(len(port)) for port in values)
    dialog = (
        f"#define MOCK_DIALOG {len(values)}\n"
        f"static const real_T mock_dialog[] = {{{numbers}}};\n"
        f"static const size_t mock_sizes[] = {{{sizes}}};\n"
    )
    own = {"vectors.h": package_files(law, asked)["vectors.h"], "dialog.h": dialog}
    for name, text in (kit_files(law, scenario) | own).items():
        (folder / name).write_text(text, "utf-8")


def tuned(law, scenario):
    """The law's parameters except its period."""
    ports = packaged(settle(scenario, law)).params
    return [port for port in ports if port.signal.name != "clock.control"]


def played(folder, law, *options, compiler=("gcc", "-std=c99"), ends=0):
    """Lines printed by a simulated run of the S-function, if it ends with the status ``ends``."""
    sources = [f"sfun_wmr_{law}.c", f"wmr_{law}.c"]
    command = [where(compiler[0]), *compiler[1:], *STRICT, *options, f"-I{HERE / 'mock'}", "-I."]
    finished([*command, *sources, "-o", "play", "-lm"], cwd=folder)
    return finished([folder / "play"], code=ends).stdout.splitlines()


@pytest.mark.parametrize(
    "law, compiler", [("prox", ("gcc", "-std=c99")), ("pursuit", ("g++", "-xc++"))]
)
@pytest.mark.slow
def test_the_s_function_plays_the_laws_vectors(tmp_path, law, compiler):
    """Only mdlUpdate changes memory, and a run may be saved; no finite input causes an error."""
    written(tmp_path, law)
    first, *rest = played(tmp_path, law, compiler=compiler)
    period, worst, count = map(float, first.split())
    assert (period, count) == (SCENARIO.clock.control, 78)
    assert worst < 1e-12
    assert rest[:2] == ["memory 1 1", "next 0 1"]


@pytest.mark.parametrize("law, guarded", [("pid", False), ("pursuit", True)])
@pytest.mark.slow
def test_a_number_in_the_dialog_is_that_number_in_an_export(tmp_path, law, guarded):
    """Limits, gains, model and guard of a new scenario in a kit of the old: the new vectors."""
    base = override(SAFE, {"guard.enabled": guarded})
    other = override(base, OTHER)
    before, after = ([port.value for port in tuned(law, each)] for each in (base, other))
    assert sum(map(ne, before, after)) >= 4
    written(tmp_path, law, base, other)
    assert float(played(tmp_path, law)[0].split()[1]) < 1e-12
    own = (tmp_path / "vectors.h").read_text("utf-8")
    written(tmp_path, law, base)
    (tmp_path / "vectors.h").write_text(own, "utf-8")
    assert float(played(tmp_path, law)[0].split()[1]) > 1e-3


@pytest.mark.slow
def test_the_dialog_refuses_by_name(tmp_path):
    """Not a number, one number too many, a text: each refusal has the name; the right value is
    accepted.
    """
    written(tmp_path, "mb", SAFE)
    lines, ports = played(tmp_path, "mb", "-DMOCK_OLD")[3:], tuned("mb", SAFE)
    assert len(lines) == 4 * len(ports)
    for k, port in enumerate(ports):
        *refused, taken = lines[4 * k : 4 * k + 4]
        assert all(line.startswith(f"{c_name(port.signal)}: ") for line in refused)
        assert taken == "taken"
    assert "limits_v_u2: 2 numbers, at least 1e-12." in lines
    dialog = tmp_path / "dialog.h"
    first, second = SAFE.limits.v_u2
    text = dialog.read_text("utf-8").replace(f" {first}, {second},", f" 5.0, {second},")
    dialog.write_text(text, "utf-8")
    told = "limits_v_u2: below limits_v_u1 in each of the two numbers."
    assert played(tmp_path, "mb", ends=5) == [told]


def scripted(folder, call):
    """Lines that one of the kit's scripts makes the stubs of Simulink print."""
    given = f"addpath('{HERE / 'stubs'}'); {call}"
    return finished([where("octave-cli"), "-qf", "--eval", given], cwd=folder).stdout.splitlines()


@pytest.mark.parametrize("controller", ["sfunction", "fmu"])
@pytest.mark.slow_but("sfunction")
def test_the_script_wires_ports_of_one_name(tmp_path, controller):
    written(tmp_path, "nn")
    lines = scripted(tmp_path, f"wmr_loop('m', '.', '{controller}')")
    wires = {f"reference/{k} controller/{k}" for k in range(1, 8)}
    wires |= {f"plant/{k} controller/{k + 7}" for k in range(1, 6)}
    wires |= {"controller/1 plant/1", "controller/2 plant/2", "no_noise_right/1 plant/3"}
    wires |= {"no_noise_left/1 plant/4", "no_thrust/1 plant/5", "no_moment/1 plant/6"}
    assert {line for line in lines if "/" in line} == wires
    fields = [line.split()[1:] for line in lines if line.startswith("FIELD")]
    given = [line.split(None, 2) for line in lines if line.startswith("PARAMETERS")]
    ports = {c_name(port.signal): port.value for port in tuned("nn", SCENARIO)}
    ports = ports if controller == "sfunction" else {}
    assert [(name, tuple(map(float, values))) for name, *values in fields] == [*ports.items()]
    assert given == ([["PARAMETERS", "sfun_wmr_nn", ", ".join(ports)]] if ports else [])


@pytest.mark.parametrize("law", ["mb", "nn"])
@pytest.mark.slow_but("mb")
def test_the_c_caller_has_the_structs_of_the_package(tmp_path, law):
    """Constants and memory have the header's fields and the law's numbers, wires its arguments."""
    written(tmp_path, law)
    lines = scripted(tmp_path, "wmr_ccaller('m')")
    header = (tmp_path / f"wmr_{law}.h").read_text("utf-8")
    system = packaged(settle(SCENARIO, law))
    space = dict(line.split(None, 2)[1:] for line in lines if line.startswith("WORKSPACE"))
    kinds = ("parameters", "parameters", system.params), ("state", "memory", system.state)
    for kind, key, ports in kinds:
        body = re.search(rf"typedef struct \{{([^}}]*)\}} wmr_{law}_{kind};", header)[1]
        fields = [field.split(":") for field in space[key].split()]
        assert [name for name, *_ in fields] == re.findall(r"wmr_real (\w+)", body)
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


def test_the_kit_is_written_and_says_what_was_tried(tmp_path):
    paths = export_fmu("simulink", law="mb", scenario=SCENARIO, out=tmp_path / "kit")
    assert {path.name for path in paths} == {
        "sfun_wmr_mb.c", "wmr_block.m", "wmr_loop.m", "wmr_ccaller.m", "README.md",
        "wmr_mb.c", "wmr_mb.h", "arithmetic.h",
    }  # fmt: skip
    assert "not tried" in (tmp_path / "kit" / "README.md").read_text("utf-8")
    with pytest.raises(ArgumentError, match="lag"):
        kit_files("mb", override(SCENARIO, {"actuator.lag": 0.02}))


def test_a_number_without_ends_may_be_any():
    """Bounds beyond the largest allowed number count as none."""
    port = Port(Signal("some.gain", "1", "a gain"), ca.SX.sym("g"), (2.0,))

    assert _parameter(port, None)["wanted"] == "a number"
    assert _parameter(port, (0.0, LARGEST))["wanted"] == "a number, at least 0"
    assert _parameter(port, (-3.0, 4.0))["wanted"] == "a number, at least -3, at most 4"
