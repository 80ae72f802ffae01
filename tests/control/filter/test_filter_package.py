"""The command filter in C: its package passes its own check and agrees with the graph."""

import math
import re
import subprocess

import numpy as np
import pytest

from tests.codegen.measured import FILTERS
from tests.codegen.packages import write_package
from tests.codegen.test_package import WARNINGS, needs, programs, run
from tests.control.filter.test_filter import scenario
from tests.tables import changes
from wmr_ctrl.codegen.package import known_footprint, package_files
from wmr_ctrl.codegen.single_precision import with_margin
from wmr_ctrl.control.filter import command_filter
from wmr_ctrl.control.filter.channels import FLAG_NAMES
from wmr_ctrl.control.filter.filter import filter_system
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.world.scenario import load_scenario, override

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
MISUSED = (
    MEMORY
    + """    const wmr_real asked[10] = {5.0f, 5.0f, (wmr_real)NAN, (wmr_real)INFINITY, 0.25f,
                                -(wmr_real)INFINITY, 1e13f, 5.0f, -5.0f, -5.0f};
    for (int k = 0; k < 11; ++k) {
        in.v_asked[k % 2] = asked[k % 10];
        in.v_asked[(k + 1) % 2] = 0.125f;
        if (k == 10) parameters.WRONG;
        if (wmr_filter_step(&parameters, &memory, &in, &out) && k < 10) return 1;
        printf("%.17g %.17g %d\\n", (double)out.v_sent[0], (double)out.v_sent[1],
               (int)out.filter_flags);
    }
    return 0;
}
"""
)
WRONG = {
    "clip": ("limits_v_u1[0] = (wmr_real)NAN", "filter_d[1] = 1e3f"),
    "band of 50 commands": ("filter_delta[0] = 1e3f", "filter_gain[1] = 0.0f"),
    "clip of slow commands": ("filter_slew[0] = -0.1f", "filter_slew[1] = (wmr_real)NAN"),
}
"""Parameters that no filter can keep, for each form of one."""
TIMED = (
    MEMORY
    + """    const wmr_real T = (wmr_real)0.05;
    const long long now[10] = {7000000000, 7050000000, 7050000000, 7040000000, 7090000000,
                               7140000000, 7150000000, 7400000000, 7450000000, 7500000000};
    wmr_filter_clock clock;
    memset(&clock, 0, sizeof clock);
    for (int k = 0; k < 14; ++k) {
        in.v_asked[0] = k % 2 ? (wmr_real)-5.0 : (wmr_real)5.0;
        in.elapsed = k < 10 ? wmr_filter_elapsed(&clock, now[k]) : k == 10 ? (wmr_real)NAN
                   : k == 11 ? (wmr_real)INFINITY : k == 12 ? -(wmr_real)INFINITY : T;
        if (wmr_filter_step(&parameters, &memory, &in, &out)) return 1;
        printf("%.17g %.17g %d\\n", (double)in.elapsed, (double)out.v_sent[0],
               (int)out.filter_flags);
    }
    return 0;
}
"""
)
"""Steps by a clock that stands still, goes back, and is late; then by what is no time."""
EACH = (
    MEMORY
    + """    static wmr_filter_parameters right;
    static wmr_filter_state driven;
    const int count = (int)(sizeof right / sizeof(wmr_real));
    right = parameters;
    ((wmr_real *)&parameters)[count - 1] = (wmr_real)NAN;
    wmr_filter_step(&parameters, &memory, &in, &out);
    parameters = right;
    for (int k = 0; k < 3; ++k) {
        in.v_asked[0] = in.v_asked[1] = (wmr_real)0.1;
        if (wmr_filter_step(&parameters, &memory, &in, &out)) return 1;
    }
    driven = memory;
    for (int i = 0; i < count; ++i) {
        parameters = right;
        memory = driven;
        ((wmr_real *)&parameters)[i] = (wmr_real)NAN;
        const int failed = wmr_filter_step(&parameters, &memory, &in, &out);
        printf("%d %g %g %d", failed, (double)out.v_sent[0], (double)out.v_sent[1],
               (int)out.filter_flags);
        parameters = right;
        printf(" %d", wmr_filter_step(&parameters, &memory, &in, &out));
        printf(" %d\\n", (int)out.filter_flags);
    }
    return 0;
}
"""
)
"""The fourth step with each parameter in turn as no number, and a step behind it.  Before the first
one of them was none, which counts for nothing: no command was sent."""
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


def built(program, folder, settings, *words, float32=False):
    """Lines that a C program around a package prints."""
    needs("gcc")
    write_package("filter", folder, settings, float32=float32)
    (folder / "main.c").write_text(program, encoding="utf-8")
    command = ["gcc", *WARNINGS, "-O1", "-ffp-contract=off", *words]
    run([*command, "main.c", "wmr_filter.c", "-lm", "-o", "main"], folder)
    return run(["./main"], folder).splitlines()


SIDES = {"limits.v_min": (-0.05, -0.8), "limits.v_max": (0.5, 0.6)}


@pytest.mark.parametrize(
    "kind, float32, stated, sides",
    [
        ("governor", False, {"delay": (0.02, 0.13), "losses": 1, "jitter": 0.004, "age": 0.08},
         {**SIDES, "filter.changing": True}),
        ("governor", True, {}, SIDES),
        ("clip", False, {}, {}),
        ("clip", True, {"scale": "axes"}, SIDES),
        ("governor", True, {"tau": ((0.1, 0.15), (0.4, 0.6)), "gain": ((0.95, 1.05), (0.8, 1.5)),
                            "delay": ((0.02, 0.02), (0.02, 0.2))}, {}),
        ("clip", False, {"loop": ("first-order", "second-order"), "damping": (0.4, 1.2)}, {}),
    ],
)  # fmt: skip
@pytest.mark.slow_but("governor-False-stated0-sides0", "governor-True-stated1-sides1")
def test_vectors_pass_and_the_example_stays_inside(kind, float32, stated, sides, tmp_path):
    write_package("filter", tmp_path, override(scenario(kind, **stated), sides), float32=float32)
    checked, example = programs("filter", tmp_path)
    called = {line.split()[-1] for line in run(["nm", "-u", "wmr_filter.o"], tmp_path).splitlines()}
    readme = (tmp_path / "README.md").read_text("utf-8")
    (told,) = re.findall("From the C library: (.*) where the", readme)
    listed = set(re.split(r", and |, | and ", told))
    assert called <= listed <= {"fabsf", "sqrt", "memcpy", "memset"}
    assert called <= {"memcpy", "memset"}
    assert "78 samples, largest error" in checked
    assert ("`limits_v_min`, `limits_v_max`" in readme) == (sides is SIDES)
    if "filter.changing" in sides:
        told = "in.limits[0] = (wmr_real)-0.05, in.limits[1] = (wmr_real)0.5;"
        assert told in (tmp_path / "example.c").read_text("utf-8")
    _, reached, _, limit, *_ = example.split()
    assert 0.4 < float(reached) <= float(limit)


def test_a_period_too_short_for_floats_is_refused():
    longest = 256 * scenario().clock.control
    for tau, float32 in ((longest, True), (1.01 * longest, False)):
        assert package_files("filter", scenario(tau=(0.2, tau)), float32=float32)
    with pytest.raises(ScenarioError, match="gets lost in a float's rounding"):
        package_files("filter", scenario(tau=(0.2, 1.01 * longest)), float32=True)


EXPM1 = """#include <stdio.h>
#include "wmr_filter.c"
int main(void)
{
    float x;
    while (fread(&x, sizeof x, 1, stdin)) {
        const float y = wmr_expm1(x);
        fwrite(&y, sizeof y, 1, stdout);
    }
    return 0;
}
"""
"""The single-precision package's exponential less one, of floats from and to a pipe."""


@pytest.mark.slow
def test_a_single_precision_exponential_is_as_right_as_its_comment_says(tmp_path):
    """The float expm1 of the C code is within 1.3 ulp, from the smallest float to overflow.

    The arguments include the known worst ones, both zeros, infinities and NaN.
    """
    sizes = 10 ** np.random.default_rng(0).uniform(-45, 1.94, 4000)
    worst = [float.fromhex("0x1.125cf2p+4"), float.fromhex("0x1.63a7bap-2"), 17.5, 3e-8, 88.7228]
    size = np.float32([*sizes, *worst, 0.0, 89.0, 1e30, math.inf])
    given = np.concatenate([size, -size, np.float32([math.nan])])
    needs("gcc")
    write_package("filter", tmp_path, scenario(), float32=True)
    (tmp_path / "main.c").write_text(EXPM1, encoding="utf-8")
    run(["gcc", *WARNINGS, "-O2", "-ffp-contract=off", "main.c", "-o", "main"], tmp_path)
    done = subprocess.run(
        [tmp_path / "main"], input=given.tobytes(), stdout=subprocess.PIPE, check=True
    )
    found, true = np.frombuffer(done.stdout, dtype=np.float32), np.expm1(given.astype(float))
    with np.errstate(over="ignore"):
        finite = np.isfinite(np.float32(true))
    unit = np.spacing(np.abs(np.float32(true[finite])))

    assert (np.abs(found[finite] - true[finite]) <= 1.3 * unit).all()
    np.testing.assert_array_equal(found[~finite], np.where(true[~finite] > 0, math.inf, math.nan))
    np.testing.assert_array_equal(np.signbit(found[:-1]), np.signbit(given[:-1]))


def assert_shown(words, made, float32):
    """Assert that a package printed the commands and flags that the graph made."""
    *sent, flags = words
    bits = {name: bit for bit, name in FLAG_NAMES.items()}
    close = {"rel": 2e-3, "abs": 1e-5} if float32 else {"rel": 1e-12, "abs": 1e-15}
    assert [*map(float, sent)] == pytest.approx(list(made.command[: len(sent)]), **close)
    assert int(flags) == sum(bits[flag] for flag in made.flags)


@pytest.mark.parametrize(
    "name, float32",
    [("clip", False), ("governor", True), ("band", True), ("clip of slow commands", False)],
)
@pytest.mark.slow_but("clip-False", "governor-True")
def test_untimely_calls_are_what_the_graph_says(name, float32, tmp_path):
    """A clock's readings are whole nanoseconds, converted to the nearest double."""
    key = "band of 50 commands" if name == "band" else name
    stated = {**FILTERS[key], "clock.control": 0.05}
    stated |= {"filter.jitter": 1e-6} if name != "clip of slow commands" else {}
    settings = load_scenario("paper-simulation", stated)
    stepped, late = command_filter(settings), []
    for k, line in enumerate(built(TIMED, tmp_path, settings, float32=float32)):
        since, *shown = line.split()
        odometry = ((0.0, 0.0),) if name == "governor" else ()
        made = stepped.step((-5.0 if k % 2 else 5.0, 0.0), *odometry, dt=float(since) or None)
        assert_shown(shown, made, float32)
        late.append("late" in made.flags)
    assert late == [False, False, True, True, False, False, True, True, *[False] * 2,
                    True, True, True, False]  # fmt: skip


def test_a_limit_of_wheels_is_lowered_in_single_precision():
    """The rounding margin lowers ``filter.wheel_speed``, too; a rim once reached 1 + 2e-7 of it."""
    system = filter_system(scenario(wheel_speed=1.2))
    pairs = zip(system.params, with_margin(system).params, strict=True)
    lowered = {old.signal.name for old, new in pairs if old.value != new.value}
    assert lowered == {"limits.v_u1", "filter.wheel_speed"}


WHEELS = {
    "wheels beside": FILTERS["governor"] | changes("""
        filter.wheel_speed = 1.2
        filter.scale = turn
        filter.delay = [0.02, 0.06]
        filter.losses = 1
        filter.age = 0.12
    """),
    "clip of wheels": {**FILTERS["clip"], "filter.wheel_speed": 1.2},
}  # fmt: skip
WITHOUT_EFFECT = {
    "clip": {"clock.control": 8}, "clip of wheels": {"clock.control": 8},
    "clip of slow commands": {"filter.d[1]": 0, "filter.d[2]": 0},
}  # fmt: skip
"""Parameters that no limit hangs on, and the flag of a step in which they are no number."""


@pytest.mark.parametrize(
    "name, float32",
    [
        ("clip", False),
        ("clip", True),
        ("wheels beside", False),
        ("clip of wheels", False),
        ("clip of slow commands", True),
        ("governor, delay of 0 to 30 ms", True),
        ("band of 50 commands", False),
    ],
)
@pytest.mark.slow_but("clip-False", "wheels beside-False")
def test_each_parameter_that_is_no_number_is_noticed_in_any_step(name, float32, tmp_path):
    """(0, 0) is sent with the flag "unsound"; a band continues to do so until it is restarted."""
    settings = load_scenario("paper-simulation", {**FILTERS, **WHEELS}[name])
    lines = built(EACH, tmp_path, settings, float32=float32)
    params = command_filter(settings).system.params
    names = [element for item in params for element in item.signal.elements]
    assert len(lines) == len(names)
    unseen = WITHOUT_EFFECT.get(name, {})
    assert set(unseen) <= set(names)
    tabled = settings.filter.kind == "band"
    for parameter, line in zip(names, lines, strict=True):
        failed, *sent, flags, again, later = map(float, line.split())
        if parameter in unseen:
            assert (failed, int(flags) & ~1) == (0, unseen[parameter]), parameter
        else:
            assert (failed, *sent, flags) == (float(tabled), 0.0, 0.0, 32.0), parameter
        assert (again, int(later) & 32) == ((1, 32) if tabled else (0, 0)), parameter


@pytest.mark.parametrize(
    "name, float32",
    [
        ("clip", False),
        ("clip", True),
        ("band of 50 commands", False),
        ("clip of slow commands", True),
    ],
)
@pytest.mark.slow_but("clip-False", "clip-True")
def test_misuse_gives_a_safe_command_and_its_flag(name, float32, tmp_path):
    """The C filter does as the graph does: a refused command means 0, within the slew limits."""
    settings = load_scenario("paper-simulation", FILTERS[name])
    lines = [
        built(MISUSED, tmp_path, settings, f"-DWRONG={wrong}", float32=float32)
        for wrong in WRONG[name]
    ]

    assert all(own[-1] == "0 0 32" for own in lines)
    stepped, refused = command_filter(settings), 0
    asked = (5.0, 5.0, math.nan, math.inf, 0.25, -math.inf, 1e13, 5.0, -5.0, -5.0)
    for k, line in enumerate(lines[0][:-1]):
        made = stepped.step((asked[k], 0.125) if k % 2 == 0 else (0.125, asked[k]))
        assert_shown(line.split(), made, float32)
        refused += "refused" in made.flags
    assert refused == 4


def test_a_parameter_that_changes_counts_from_the_next_step_on(tmp_path):
    """Stored values that depend on parameters are recomputed."""
    sent = [float(line) for line in built(CHANGED, tmp_path, scenario())]

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


def test_a_package_that_was_not_measured_tells_of_one_like_it():
    readme = package_files("filter", scenario("clip", scale="axes"))["README.md"]
    told = re.search(r"number of operations, (\d+), takes (\d+) bytes", readme)
    assert told
    assert "were not measured" in readme
    measured = known_footprint("filter", False, False, int(told[1]))
    assert measured
    assert measured.code == int(told[2])
    own = package_files("filter", load_scenario("paper-simulation", FILTERS["clip"]))["README.md"]
    assert "number of operations" not in own
