"""The command filter in C: its package passes its own check and says what the graph says."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest

from tests.codegen.test_package import WARNINGS, needs, run
from tests.filter.test_filter import scenario
from wmr_ctrl.codegen.package import package_files
from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.filter import command_filter
from wmr_ctrl.filter.channels import FLAG_NAMES
from wmr_ctrl.scenario import load_scenario

MEMORY = """#include <math.h>
#include <stdio.h>
#include <string.h>
#include "wmr_filter.h"
int main(void)
{
    wmr_filter_parameters parameters;
    wmr_filter_state memory;
    wmr_filter_inputs in;
    wmr_filter_outputs out;
    memset(&in, 0, sizeof in);
    wmr_filter_defaults(&parameters);
    wmr_filter_start(&memory);
"""
"""Begin of a program that steps the filter."""
ODD = (
    MEMORY
    + """    const double asked[4] = {5.0, NAN, INFINITY, 5.0};
    for (int k = 0; k < 4; ++k) {
        in.v_asked[0] = asked[k];
        in.v_odometry[0] = k == 2 ? NAN : 0.0;
        if (wmr_filter_step(&parameters, &memory, &in, &out)) return 1;
        printf("%.17g %.17g %d\\n", out.v_sent[0], out.v_sent[1], (int)out.filter_flags);
    }
    return 0;
}
"""
)
CHANGED = (
    MEMORY
    + """    in.v_asked[0] = 5.0;
    for (int k = 0; k < 6; ++k) {
        if (k == 3) parameters.filter_tau[0] *= 0.5;
        if (wmr_filter_step(&parameters, &memory, &in, &out)) return 1;
        printf("%.17g\\n", out.v_sent[0]);
    }
    return 0;
}
"""
)


def written(folder: Path, kind: str, float32: bool = False, **stated: object) -> None:
    for name, text in package_files("filter", scenario(kind, **stated), float32=float32).items():
        (folder / name).write_text(text, encoding="utf-8")


def printed_by(program: str, folder: Path) -> list[str]:
    """Lines of a C program around the governor's package."""
    needs("gcc")
    written(folder, "governor")
    (folder / "main.c").write_text(program, encoding="utf-8")
    command = ["gcc", "-std=c99", "-ffp-contract=off", "main.c", "wmr_filter.c", "-lm"]
    run([*command, "-o", "main"], folder)
    return run(["./main"], folder).splitlines()


@pytest.mark.parametrize(
    ("kind", "float32", "stated"),
    [
        ("governor", False, {"delay": (0.02, 0.13), "losses": 1, "jitter": 0.004, "age": 0.08}),
        ("governor", True, {}),
        ("clip", False, {}),
        ("clip", True, {"scale": "axes"}),
    ],
)
def test_vectors_pass_and_the_example_stays_inside(kind, float32, stated, tmp_path):
    needs("gcc")
    written(tmp_path, kind, float32, **stated)
    command = ["gcc", *WARNINGS, "-O2", "-ffp-contract=off"]
    for program in ("check", "example"):
        run([*command, f"{program}.c", "wmr_filter.c", "-lm", "-o", program], tmp_path)
    assert "72 samples, largest error" in run(["./check"], tmp_path)
    words = run(["./example"], tmp_path).split()
    assert 0.5 < float(words[1]) <= float(words[3])


def test_numbers_that_are_none_are_what_the_graph_says(tmp_path):
    lines = printed_by(ODD, tmp_path)
    governor, bits = command_filter(scenario()), {name: bit for bit, name in FLAG_NAMES.items()}
    for k, line in enumerate(lines):
        asked = ((5.0, 0.0), (math.nan, 0.0), (math.inf, 0.0), (5.0, 0.0))[k]
        made = governor.step(asked, (math.nan if k == 2 else 0.0, 0.0))
        sent, turn, flags = line.split()
        assert (float(sent), float(turn)) == pytest.approx(made.command, rel=1e-14)
        assert int(flags) == sum(bits[flag] for flag in made.flags)


def test_a_parameter_that_changes_counts_from_the_next_step_on(tmp_path):
    """Values that the memory keeps of parameters are made anew."""
    sent = [float(line) for line in printed_by(CHANGED, tmp_path)]

    system = command_filter(scenario()).system
    machine = system.function("step", [system.update, system.y])
    names = [name for item in system.params for name in item.signal.elements]
    p, place = list(system.p0), names.index("filter.tau[1]")
    x, expected = system.x0, []
    for k in range(6):
        p[place] *= 0.5 if k == 3 else 1.0
        x, y = machine([5.0, 0.0, 0.0, 0.0, 0.0, 0.0], x, p)
        expected.append(float(y[0]))
    assert sent == pytest.approx(expected, rel=1e-14)
    assert sent[3] < sent[2]


def test_a_scenario_without_filter_is_refused():
    with pytest.raises(ScenarioError, match="has no command filter"):
        package_files("filter", load_scenario("paper-simulation"))


def test_the_command_writes_it(tmp_path):
    command = [
        sys.executable,
        "-m",
        "wmr_ctrl",
        "codegen",
        "filter",
        "--set",
        "filter.kind=clip",
        "--out",
        str(tmp_path),
    ]
    assert subprocess.run(command, check=False, capture_output=True).returncode == 0
    assert {"wmr_filter.h", "wmr_filter.c"} <= {item.name for item in tmp_path.iterdir()}
