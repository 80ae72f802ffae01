"""The compiled kernels against CasADi's virtual machine, on the very graphs they came from."""

import shutil

import numpy as np
import pytest

from tests.commands import finished
from wmr_ctrl.codegen.build import LOOP, build_law, build_loop, program_of, unity
from wmr_ctrl.codegen.kernels import loop_kernels
from wmr_ctrl.control.controller import watched_controller
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import elements
from wmr_ctrl.simulation.memory import REALS, opened
from wmr_ctrl.world.effect import Rate
from wmr_ctrl.world.scenario import load_scenario

SCENARIO = load_scenario("paper-simulation")


def settled(law):
    return settle(SCENARIO, law)


def compiled(law, name):
    """Call of one exported kernel: arrays in, arrays out."""
    build = build_law if name == "controller" else build_loop
    entry = opened(build(settled(law)).library)[f"wmr_export_{name}"]
    entry.restype = None

    def call(inputs, sizes):
        outputs = [np.zeros(max(size, 1)) for size in sizes]
        given = [
            np.ascontiguousarray(item, dtype=float) if np.size(item) else np.zeros(1)
            for item in inputs
        ]
        entry(*(item.ctypes.data_as(REALS) for item in (*given, *outputs)))
        return [item[:size] for item, size in zip(outputs, sizes, strict=True)]

    return call


def admissible(draw, size):
    """(inputs, memory): all three regions of v_c0, both signs, v near the limits and the kinks."""
    reference = np.array([*draw.normal(size=3), 0.2, 0.1, 0.0, 0.0])
    pose = reference[:3] + draw.normal(size=3) * 10 ** draw.uniform(-6, 1)
    v = draw.choice([draw.uniform(-1, 1), 0.8, -0.8, 0.8 + 1e-9, 0.999999, 0.0]) * np.array(
        [1.0, 1.5]
    )
    return np.concatenate([reference, pose, v]), draw.normal(size=size) * draw.choice(
        [0.0, 1.0, 30.0]
    )


def assert_near(ours, theirs):
    for one, other in zip(ours, theirs, strict=True):
        near = 1e-13 * (1 + abs(other).max(initial=0))
        assert one == pytest.approx(other, rel=1e-13, abs=near)


@pytest.mark.parametrize("law", ["mb", "prox", "nn", "kanayama"])
@pytest.mark.slow_but("mb", "prox")
def test_c_equals_the_virtual_machine(law):
    """To 1e-13 per step, all regions, both signs, boundaries."""
    item = watched_controller(settled(law))
    machine, step = item.function("step", [item.update, item.y]), compiled(law, "controller")
    draw = np.random.default_rng(0)
    for _ in range(400):
        u, x = admissible(draw, len(item.x0))
        wanted = [part.full().ravel() for part in machine(u, x, item.p0)]
        assert_near(step([u, x, item.p0], [len(x), 2]), wanted)


@pytest.mark.parametrize("law", ["prox", "nn"])
@pytest.mark.slow_but("prox")
def test_a_logged_sample_equals_the_virtual_machine(law):
    """Reference, sensors, diagnostics and all, from such states."""
    loop, p = program_of(settled(law)).loop, np.array(build_loop(settled(law)).parameters[0])
    sample = next(item.function for item in loop_kernels(loop) if item.name == "sample_logged")
    step, names = compiled(law, "sample_logged"), elements(loop.columns)
    desired = [names.index(f"{name}_d") for name in ("x", "y", "theta")]
    sizes = [sample.numel_out(k) for k in range(3)]
    draw = np.random.default_rng(0)
    for _ in range(200):
        u, memory = admissible(draw, len(loop.x0) - 5)
        k, w = float(draw.integers(8000)), draw.uniform(-1, 1, loop.draws(Rate.SAMPLE).numel())
        at = sample(k, np.zeros(len(loop.x0)), p, w)[2].full().ravel()[desired]
        x = np.concatenate([at + u[7:10] - u[:3], u[10:], memory])
        wanted = [part.full().ravel() for part in sample(k, x, p, w)]
        assert_near(step([np.array([k]), x, p, w], sizes), wanted)


@pytest.mark.parametrize("compiler, lanes", [("gcc", 0), ("gcc", 4), ("clang", 0)])
@pytest.mark.slow_but("gcc-0")
def test_sources_compile_without_a_warning(compiler, lanes, tmp_path):
    if not shutil.which(compiler):
        pytest.skip(f"NOT RUN: {compiler} is not on this machine")
    program = program_of(settled("nn"))
    files = unity(program.generated_lanes, LOOP) if lanes else unity(program.generated)
    for name, text in files.items():
        (tmp_path / name).write_text(text, "utf-8")
    unit = ["library.c", "-DWMR_SET=four", "-DWMR_LANES=4", "-mavx2"] if lanes else ["native.c"]
    warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    command = [compiler, "-std=c99", "-O1", *warnings, "-c", *unit]

    finished(command, cwd=tmp_path)


def test_only_marked_names_leave_the_library():
    if not shutil.which("nm"):
        pytest.skip("nm is not on this machine")
    listed = finished(["nm", "-D", "--defined-only", build_loop(settled("mb")).library]).stdout
    names = {line.split()[-1] for line in listed.splitlines()}

    assert names
    assert all(name.startswith("wmr_") for name in names), names
