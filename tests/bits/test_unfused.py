"""No compiler fuses a product with a sum, not even where a difference stands beside it."""

import ctypes as ct
import re
import shutil

import numpy as np
import pytest

from tests.bits.cases import case
from tests.bits.platforms import processor
from wmr_ctrl.codegen.build import X86, flags_of, vector_sets
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain
from wmr_ctrl.control.laws.registry import NAMES

TEXT = """
__attribute__((visibility("default")))
void pair(double *restrict o, const double *restrict a, const double *restrict b,
          const double *restrict c)
{
    o[0] = a[0] * b[0] - c[0];
    o[1] = a[1] * b[1] + c[1];
}
"""


def assert_unfused(toolchain):
    library = ct.CDLL(str(build_library({"pair.c": TEXT}, toolchain, name="pair")))
    for a, b, c in np.random.default_rng(1).normal(size=(200, 3, 2)):
        out, product = np.zeros(2), a * b
        library.pair(*(ct.c_void_p(item.ctypes.data) for item in (out, a, b, c)))
        assert out.tolist() == [product[0] - c[0], product[1] + c[1]]


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.slow_but("gcc")
def test_builds_for_this_processor(compiler, monkeypatch):
    if shutil.which(compiler) is None:
        pytest.skip(f"NOT RUN: {compiler} is not on this machine")
    monkeypatch.setenv("WMR_CTRL_CC", compiler)

    assert_unfused(find_toolchain(native=True))


@pytest.mark.parametrize("vectors", X86, ids=lambda item: item.name)
def test_builds_for_vectors(vectors):
    if vectors not in vector_sets():
        pytest.skip("NOT RUN: not an x86 processor")
    toolchain = find_toolchain()
    if {"avx2": "fma", "avx512": "avx512dq"}[vectors.name] not in processor():
        pytest.skip(f"NOT RUN: this processor has no {vectors.name}")

    assert_unfused(toolchain.with_flags(*flags_of(vectors, toolchain)))


@pytest.mark.parametrize("law", NAMES)
@pytest.mark.slow_but("mb")
def test_loops_take_one_number_after_the_other(law):
    """So no two stores of a loop are adjacent in memory."""
    text = case(law, "everything").program.generated["kernels.c"]
    places = set(re.findall(r"\[([^\]]*\bj\b[^\]]*)\]", text))

    assert all(re.fullmatch(r"j( [+-] \d+)?", place) for place in places)
    assert places or law != "nn"
