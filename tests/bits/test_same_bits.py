"""All columns of all laws have the same bits on every platform, at every width, in every engine."""

import pytest

from tests.bits.cases import bits_of, different
from tests.bits.platforms import HERE, Platform, differences
from tests.compilers import ARM, NODE, QEMU, SIMD128, WASM, WINE, ZIG
from wmr_ctrl.codegen.compiler import UNFUSED

NATIVE = "-march=native"
LANES_OF_OURS = ("-O3", "-fno-tree-vectorize")
"""Compiler flags of our own libraries for lanes."""
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
EVERYWHERE = {platform.name: platform for platform in HERE_NOW + ELSEWHERE}
"""Platforms by name; ``python -m tests.bits`` tries all of them."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, law",
    [
        ("gcc -O2", "pid"),
        ("gcc -O3 native", "smc"),
        ("clang -O3", "mb"),
        ("zig -O3", "prox"),
        ("gcc 8 lanes", "nn"),
        ("aarch64", "kanayama"),
        ("wasm", "pursuit"),
        ("wasm 2 lanes", "smc"),
    ],
)
def test_platforms_agree(name, law, tmp_path):
    """The platform gives our library's bits with all effects and the guard, over 80 s.

    ``python -m tests.bits`` takes every law and case on every platform.
    """
    assert differences(EVERYWHERE[name], law, ["everything"], tmp_path) == []


def test_a_single_bit_is_seen_and_placed():
    bits = bytearray(bits_of("mb", "plain"))
    assert different("mb", "plain", bits) == ""
    assert different("mb", "plain", bits[:-8]).endswith(f"for {len(bits)}")
    bits[8] ^= 1
    assert different("mb", "plain", bits).startswith("mb, plain: row 0 ")
