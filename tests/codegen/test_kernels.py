"""The compiled kernels against CasADi's virtual machine, on the very graphs they came from."""

import numpy as np
import pytest

from tests.commands import finished
from tests.compilers import where
from wmr_ctrl.codegen.build import LOOP, NATIVE, build_loop, program_of, unity
from wmr_ctrl.codegen.kernels import loop_kernels
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.signals import elements
from wmr_ctrl.results import write_all
from wmr_ctrl.simulation.memory import REALS, opened
from wmr_ctrl.world.effect import Rate
from wmr_ctrl.world.scenario import load_scenario

SCENARIO = load_scenario("paper-simulation")


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


@pytest.mark.parametrize("law", ["prox", "nn"])
@pytest.mark.slow_but("prox")
def test_a_logged_sample_equals_the_virtual_machine(law):
    """Reference, sensors, diagnostics and all other values to 1e-13: all regions, both signs,
    boundaries.
    """
    setup = settle(SCENARIO, law)
    loop, built = program_of(setup).loop, build_loop(setup)
    sample = next(item.function for item in loop_kernels(loop) if item.name == "sample_logged")
    step, p = opened(built.library).wmr_export_sample_logged, np.array(built.parameters[0])
    desired = [elements(loop.columns).index(f"{name}_d") for name in ("x", "y", "theta")]
    draw = np.random.default_rng(0)
    for _ in range(200):
        u, memory = admissible(draw, len(loop.x0) - 5)
        k, w = float(draw.integers(8000)), draw.uniform(-1, 1, loop.draws(Rate.SAMPLE).numel())
        at = sample(k, np.zeros(len(loop.x0)), p, w)[2].full().ravel()[desired]
        x = np.concatenate([at + u[7:10] - u[:3], u[10:], memory])
        found = [np.zeros(sample.numel_out(i)) for i in range(3)]
        step(*(item.ctypes.data_as(REALS) for item in (np.array([k]), x, p, w, *found)))
        for one, other in zip(found, sample(k, x, p, w), strict=True):
            wanted = other.full().ravel()
            near = 1e-13 * (1 + abs(wanted).max(initial=0))
            assert one == pytest.approx(wanted, rel=1e-13, abs=near)


@pytest.mark.parametrize("compiler, lanes", [("gcc", 0), ("gcc", 4), ("clang", 0)])
@pytest.mark.slow_but("gcc-0")
def test_sources_compile_without_a_warning(compiler, lanes, tmp_path):
    program = program_of(settle(SCENARIO, "nn"))
    files = unity(program.generated_lanes, LOOP) if lanes else unity(program.generated)
    write_all(files, tmp_path)
    unit = f"{LOOP[0]} -DWMR_SET=four -DWMR_LANES=4 -mavx2" if lanes else NATIVE[0]
    warnings = "-std=c99 -O1 -Wall -Wextra -Wpedantic -Werror -c"
    finished([where(compiler), *warnings.split(), *unit.split()], cwd=tmp_path)


def test_only_marked_names_leave_the_library():
    library = build_loop(settle(SCENARIO, "mb")).library
    listed = finished([where("nm"), "-D", "--defined-only", library]).stdout
    names = {line.split()[-1] for line in listed.splitlines()}

    assert names
    assert all(name.startswith("wmr_") for name in names), names
