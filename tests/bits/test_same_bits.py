"""All columns of all laws have the same bits on every platform, at every width, in every engine."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest

from tests.bits.cases import CASES, SEED, bits_of, case, different
from tests.bits.platforms import HERE, Platform, differences
from tests.compilers import ARM, NODE, QEMU, SIMD128, WASM, WINE, ZIG
from tests.matrix import headed, turns
from wmr_ctrl.codegen.build import build_batch, vector_sets
from wmr_ctrl.codegen.compiler import UNFUSED
from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.core.signals import elements
from wmr_ctrl.results import Monitor
from wmr_ctrl.simulation.batch import run_logged
from wmr_ctrl.simulation.engines import runnable_of
from wmr_ctrl.simulation.many import each_task
from wmr_ctrl.simulation.memory import Task
from wmr_ctrl.simulation.memory import vector_sets as usable

NATIVE = "-march=native"
LANES_OF_OURS = ("-O3", "-fno-tree-vectorize")
"""As the library for lanes is compiled."""
HERE_NOW = (
    Platform("gcc -O2", ("gcc", "-O2")),
    Platform("gcc -O3 native", ("gcc", "-O3", NATIVE, UNFUSED)),
    Platform("clang -O3", ("clang", "-O3")),
    Platform("clang -O2 native", ("clang", "-O2", NATIVE)),
    Platform("zig -O3", (*ZIG, "-O3", "-mcpu=baseline")),
    Platform("zig -O2 native", (*ZIG, "-O2", "-mcpu=native")),
    Platform("gcc 2 lanes", ("gcc", "-O2"), 2),
    Platform("gcc 4 lanes", ("gcc", *LANES_OF_OURS, "-march=x86-64-v3"), 4),
    Platform("gcc 8 lanes", ("gcc", *LANES_OF_OURS, "-march=x86-64-v4"), 8),
    Platform("clang 4 lanes", ("clang", "-O2", "-march=x86-64-v3"), 4),
    Platform("clang 8 lanes", ("clang", "-O3", "-march=x86-64-v4"), 8),
)
BOARD = (*ZIG, "-target", ARM, "-O2")
WINDOWS = (*ZIG, "-target", "x86_64-windows-gnu", "-O2")
ELSEWHERE = (
    Platform("aarch64", BOARD, 0, QEMU),
    Platform("aarch64 2 lanes", BOARD, 2, QEMU),
    Platform("windows", WINDOWS, 0, WINE, suffix=".exe"),
    Platform("wasm", WASM, 0, NODE, HERE / "run.mjs", ".wasm"),
    Platform("wasm 2 lanes", (*WASM, *SIMD128), 2, NODE, HERE / "run.mjs", ".wasm"),
)
EVERYWHERE = HERE_NOW + ELSEWHERE


@pytest.mark.slow
@pytest.mark.parametrize("law", NAMES)
def test_cases_differ_and_the_guard_acts_in_its_own(law: str) -> None:
    assert len({bits_of(law, name) for name in CASES}) == len(CASES)
    for name in ("guarded", "everything"):
        task = Task(case(law, name).loop, SEED)
        (run,) = each_task([task], lambda _, run: run, engine="native")
        assert run["clip_active"].any()


@pytest.mark.slow
@pytest.mark.parametrize("law", NAMES)
def test_laws_agree(law: str, tmp_path: Path) -> None:
    """With the first compiler; without guard and effects and with either, over 80 s."""
    assert differences(EVERYWHERE[0], law, tuple(CASES)[:-1], tmp_path) == []


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(EVERYWHERE)), ids=[p.name for p in EVERYWHERE])
def test_platforms_agree(number: int, tmp_path: Path) -> None:
    """With all effects and the guard, over 80 s; laws take turns.

    ``python -m tests.bits`` takes every law and case on every platform.
    """
    platform, law = EVERYWHERE[number], NAMES[number % len(NAMES)]
    assert differences(platform, law, ["everything"], tmp_path) == []


@pytest.mark.usefixtures("every_set_of_instructions")
@pytest.mark.parametrize(
    ("law", "vectors"), turns(headed("mb", NAMES), [item.name for item in vector_sets()], shown=0)
)
def test_lanes_of_our_library_are_single_runs(law: str, vectors: str) -> None:
    """Each lane has a seed of its own."""
    one = case(law, "everything")
    loop = runnable_of(build_batch(one.setup), one.setup)
    width = {item.name: item.lanes for item in usable(loop.compiled.library)}.get(vectors)
    if width is None:
        pytest.skip(f"NOT RUN: this processor or compiler has no {vectors}")
    seeds = [SEED + k for k in range(width)]
    together = rows_of(Task(loop, seed, vectors=vectors) for seed in seeds)
    alone = rows_of(Task(one.loop, seed) for seed in seeds)

    assert together == alone
    assert bits_of(law, "everything").startswith(together[0][0])


def rows_of(tasks: Iterable[Task]) -> list[tuple[bytes, Monitor]]:
    """Bits of the log, and what was watched, of each."""
    return run_logged(list(tasks), lambda _, rows, watched: (rows.tobytes(), watched))


def test_a_single_bit_is_seen_and_placed() -> None:
    bits = bytearray(bits_of("mb", "plain"))
    row = 8 * len(elements(case("mb", "plain").compiled.layout.columns))
    bits[3 * row + 8] ^= 1

    assert "row 3" in different("mb", "plain", bytes(bits))
    assert different("mb", "plain", bytes(bits[:-8])).endswith(f"for {len(bits)}")
