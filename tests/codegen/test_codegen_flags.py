"""Compiler flags that change values: exported C refuses them, or they change nothing."""

from functools import cache
from subprocess import run

import pytest

from tests.codegen.measured import COMPILER, FILTERS, TARGET
from tests.codegen.test_package import needs
from tests.commands import finished
from tests.ros2.test_scans import RADIUS, STATED
from wmr_ctrl.codegen.package import CORRIDOR, FILTER, files_of, package_files
from wmr_ctrl.codegen.reference_package import reference_files
from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.export.fmi.files import sources_of
from wmr_ctrl.export.fmi.fmu_files import model_of
from wmr_ctrl.export.simulink import kit_files
from wmr_ctrl.ros2.filter_core import core_files
from wmr_ctrl.ros2.sight import SightSettings
from wmr_ctrl.theory.corridor import corridor_monitor
from wmr_ctrl.world.scenario import load_scenario, override

SAFE = load_scenario("safe-simulation")
STILL = override(SAFE, {"changes": []})
FILTERED = load_scenario("paper-simulation", FILTERS["governor"])
GATE = GateSettings(odometry="none")
FLAGS = (
    "-ffast-math", "-Ofast", "-funsafe-math-optimizations", "-fassociative-math",
    "-fassociative-math -fno-signed-zeros -fno-trapping-math", "-freciprocal-math",
    "-ffinite-math-only", "-fsingle-precision-constant",
)  # fmt: skip
REFUSALS = ("compile without -ffast-math", "compile_without_fsingle_precision_constant")
NO_MACROS = (
    "-U__FAST_MATH__", "-U__ASSOCIATIVE_MATH__", "-U__RECIPROCAL_MATH__", "-U__FINITE_MATH_ONLY__",
    "-U__GCC_IEC_559",
)  # fmt: skip
"""A compiler of which the C learns nothing."""
STATUS = """#include <stdio.h>
#include <string.h>
#include "wmr_{law}.h"
int main(void)
{{
    wmr_{law}_parameters parameters;
    wmr_{law}_state memory;
    wmr_{law}_inputs in;
    wmr_{law}_outputs out;
    memset(&in, 0, sizeof in);
    wmr_{law}_defaults(&parameters);
    wmr_{law}_start(&memory);
    for (int k = 0; k < 3; ++k) {{
        printf("%d ", wmr_{law}_step(&parameters, &memory, &in, &out));
        printf("%d %g\\n", (int)out.{last}, (double)*(wmr_real *)&out);
    }}
    return 0;
}}
"""
KINDS = {
    "law": lambda: package_files("nn", SAFE),
    "law-float32": lambda: package_files("nn", SAFE, float32=True),
    "filter": lambda: package_files(FILTER, FILTERED),
    "filter-float32": lambda: package_files(FILTER, FILTERED, float32=True),
    "reference": lambda: reference_files(SAFE),
    "corridor": lambda: files_of(CORRIDOR, corridor_monitor(STILL, "prox"), STILL),
    "fmu": lambda: sources_of(model_of("closed-loop", "pid", SAFE), 3).files,
    "simulink": lambda: kit_files("nn", SAFE),
    "ros": lambda: core_files(FILTERED, GATE),
    "ros-laser": lambda: core_files(
        load_scenario("paper-simulation", STATED), GATE, SightSettings(scans=("a",), radius=RADIUS)
    ),
}
"""Every kind of C that a user compiles: file name to text."""
NOT_COMPILED = ("check.c", "example.c", "sfun_wmr_nn.c")


@cache
def texts(kind):
    return KINDS[kind]()


def written(kind, folder):
    """Write the files of a kind; its units are returned."""
    for name, text in texts(kind).items():
        (folder / name).write_text(text, "utf-8")
    return sorted(path.name for path in folder.glob("*.c") if path.name not in NOT_COMPILED)


def compiled(folder, compiler, *words):
    target = TARGET if compiler == COMPILER else ("-fPIC",)
    command = [compiler, *target, "-std=c99", "-w", "-O1", "-ffp-contract=off", *words]
    return run(command, cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("compiler", ["gcc", "clang", COMPILER])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.slow_but(*(f"{kind}-gcc" for kind in KINDS if kind not in ("fmu", "ros-laser")))
def test_flag_is_refused_or_values_stay(kind, compiler, tmp_path):
    """The test vectors pass, or the first sample is refused; without vectors the instructions are
    equal.

    With Clang the ROS node is tested below and the FMU in tests/export.  The float filter converts
    nanoseconds to seconds by a constant, which may be a float.
    """
    needs(compiler)
    units = written(kind, tmp_path)
    plain = instructions(tmp_path, compiler, units)
    for flag in FLAGS:
        words = flag.split()
        done = compiled(tmp_path, compiler, *words, "-fsyntax-only", *units)
        if done.returncode:
            assert any(sentence in done.stderr for sentence in REFUSALS), (flag, done.stderr)
        elif "check.c" in texts(kind) and compiler != COMPILER:
            done = compiled(tmp_path, compiler, *words, "check.c", *units, "-lm", "-o", "check")
            assert done.returncode == 0, done.stderr
            done = run(["./check"], cwd=tmp_path, capture_output=True, text=True, check=False)
            assert done.returncode == 0 or "sample 0: refused" in done.stdout, (flag, done.stdout)
        elif compiler != "clang" and (kind, flag) != ("filter-float32", FLAGS[-1]):
            assert instructions(tmp_path, compiler, units, *words) == plain, flag


def instructions(folder, compiler, units, *words):
    done = compiled(folder, compiler, *words, "-S", *units)
    assert done.returncode == 0, done.stderr
    return [(folder / unit).with_suffix(".s").read_text("utf-8") for unit in units]


@pytest.mark.parametrize("flag", ["", *(flag for flag in FLAGS if flag != "-fassociative-math")])
def test_gcc_before_12_refuses_without_its_newer_macros(flag, tmp_path):
    """Its version and macros are simulated: it shows such flags by __GCC_IEC_559 alone.

    It ignores -fassociative-math without -fno-signed-zeros.
    """
    needs("gcc")
    written("law", tmp_path)
    older = ["-U__GNUC__", "-D__GNUC__=11", *NO_MACROS[:3]]
    done = compiled(tmp_path, "gcc", *flag.split(), *older, "-fsyntax-only", "wmr_nn.c")
    assert bool(flag) == (REFUSALS[0] in done.stderr), done.stderr


@pytest.mark.parametrize("compiler", ["gcc", "gcc-11"])
@pytest.mark.parametrize("kind", ["law", "law-float32", "filter", "filter-float32"])
@pytest.mark.slow_but("filter-gcc", "law-float32-gcc")
def test_first_step_catches_flags_that_no_macro_tells(kind, compiler, tmp_path):
    """Every step is then refused with status and flag.

    GCC ignores -fassociative-math alone; short constants do no harm to a package of floats.
    """
    needs(compiler)
    units, law = written(kind, tmp_path), kind.removesuffix("-float32").replace("law", "nn")
    for path in tmp_path.glob("arithmetic.h"):  # the flag's own check at compile time
        text = path.read_text("utf-8")
        path.write_text(text.replace("[sizeof(1.0) == sizeof(double) ? 1 : -1]", "[1]"))
    last = "filter_flags" if law == "filter" else "guard_acted"
    (tmp_path / "main.c").write_text(STATUS.format(law=law, last=last), "utf-8")
    harmless = ("", "-fassociative-math", *[FLAGS[-1]] * ("float" in kind))
    refused = "3 64 0\n" if law == "filter" else "3 0 0\n"
    for flag in ("", *FLAGS):
        words = [*flag.split(), *NO_MACROS, "main.c", *units, "-lm", "-o", "main"]
        done = compiled(tmp_path, compiler, *words)
        assert done.returncode == 0, done.stderr
        said = finished([tmp_path / "main"]).stdout
        assert said == 3 * refused or flag in harmless, flag
        assert flag or said.startswith("0 ")
