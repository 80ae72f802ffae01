"""No compiler fuses a product with a sum, not even where a difference stands beside it."""

from __future__ import annotations

import ctypes as ct
import shutil

import numpy as np
import pytest

from tests.bits.platforms import processor
from wmr_ctrl.codegen.build import X86, Vectors, flags_of, vector_sets
from wmr_ctrl.codegen.compiler import Toolchain
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain

TEXT = """
__attribute__((visibility("default")))
void pairs(double *restrict o, const double *restrict a, const double *restrict b,
           const double *restrict c, int n)
{
    for (int i = 0; i < n; ++i) {
        o[2 * i] = a[2 * i] * b[2 * i] - c[2 * i];
        o[2 * i + 1] = a[2 * i + 1] * b[2 * i + 1] + c[2 * i + 1];
    }
}
"""


def assert_unfused(toolchain: Toolchain) -> None:
    a, b, c = np.random.default_rng(1).normal(size=(3, 400))
    out = np.zeros(400)
    library = ct.CDLL(str(build_library({"pairs.c": TEXT}, toolchain, name="pairs")))
    library.pairs(*(ct.c_void_p(item.ctypes.data) for item in (out, a, b, c)), 200)
    product = a * b

    assert (out[::2] == product[::2] - c[::2]).all()
    assert (out[1::2] == product[1::2] + c[1::2]).all()


@pytest.mark.parametrize("compiler", ["gcc", "clang", "zig cc"])
def test_builds_for_this_processor(compiler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if compiler != "zig cc" and shutil.which(compiler) is None:
        pytest.skip(f"NOT RUN: {compiler} is not on this machine")
    monkeypatch.setenv("WMR_CTRL_CC", compiler)

    assert_unfused(find_toolchain(native=True))


@pytest.mark.parametrize("vectors", X86, ids=lambda item: item.name)
def test_builds_for_vectors(vectors: Vectors) -> None:
    if vectors not in vector_sets():
        pytest.skip("NOT RUN: not an x86 processor")
    toolchain = find_toolchain()
    if {"avx2": "fma", "avx512": "avx512dq"}[vectors.name] not in processor():
        pytest.skip(f"NOT RUN: this processor has no {vectors.name}")

    assert_unfused(toolchain.with_flags(*flags_of(vectors, toolchain)))
