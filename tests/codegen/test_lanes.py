"""The lanes' mathematics: right to 2 ulp, the same bits for every set of vector instructions."""

from __future__ import annotations

import ctypes as ct
import functools
from collections.abc import Callable

import numpy as np
import pytest

from wmr_ctrl.api import scenario_of
from wmr_ctrl.codegen.lanes import build_batch, flags_of, vector_sets
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.toolchain import build_library, find_toolchain
from wmr_ctrl.sim.batch_memory import vector_sets as usable

FUNCTIONS = ("exp", "log", "sin", "cos", "tanh", "sqrt", "log1p", "floor")
_CODE = '#include "lanes.h"\n#include <string.h>\n' + "".join(
    f"""
__attribute__((visibility("default"))) void each_{name}(double *a, int64_t count)
{{
    for (int64_t i = 0; i < count; i += WMR_LANES) {{
        wmr_v v;
        memcpy(&v, a + i, sizeof v);
        v = wmr_{name}(v);
        memcpy(a + i, &v, sizeof v);
    }}
}}
"""
    for name in FUNCTIONS
)
RANGES = {
    "exp": [(-745.0, 709.7), (-1.0, 1.0), (-1e-9, 1e-9)],
    "log": [(1e-300, 1e-3), (0.5, 2.0), (1.0, 1e300), (1e-323, 1e-308)],
    "sin": [(-10.0, 10.0), (-999.0, 999.0), (-1e-9, 1e-9), (1e4, 1e9)],
    "cos": [(-10.0, 10.0), (-999.0, 999.0), (1e4, 1e9)],
    "tanh": [(-3.0, 3.0), (-1e-6, 1e-6), (0.6, 0.65)],
    "sqrt": [(0.0, 1e9), (0.0, 1e-300)],
}
SETS = {item.name: item for item in vector_sets()}
every_set = pytest.mark.parametrize("vectors", SETS)


@functools.cache
def available() -> list[str]:
    """The sets that this processor has, as a library for lanes finds out."""
    return [
        item.name for item in usable(build_batch(scenario_of("paper-simulation"), "mb").library)
    ]


def functions(vectors: str) -> Callable[[str, np.ndarray], np.ndarray]:
    if vectors not in available():
        pytest.skip(f"NOT RUN: this processor has no {vectors}")
    header = (runtime_dir() / "lanes.h").read_text(encoding="utf-8")
    toolchain = find_toolchain()
    toolchain = toolchain.with_flags(*flags_of(SETS[vectors], toolchain))
    path = build_library({"each.c": _CODE, "lanes.h": header}, toolchain, name="each")
    library = ct.CDLL(str(path))

    def call(name: str, values: np.ndarray) -> np.ndarray:
        size = -(-len(values) // 8) * 8
        given = np.resize(np.asarray(values, dtype=float), size)
        library[f"each_{name}"](ct.c_void_p(given.ctypes.data), ct.c_int64(size))
        return given[: len(values)]

    return call


@pytest.mark.parametrize(
    ("name", "low", "high"), [(n, *r) for n, each in RANGES.items() for r in each]
)
@every_set
def test_functions_are_right_to_2_ulp(vectors: str, name: str, low: float, high: float) -> None:
    if np.finfo(np.longdouble).nmant < 60:
        pytest.skip("NOT RUN: no wider type to compare with")
    x = np.random.default_rng(0).uniform(low, high, 100_000)
    found = functions(vectors)(name, x).astype(np.longdouble)
    wanted = getattr(np, name)(x.astype(np.longdouble))
    error = abs(found - wanted) / np.spacing(np.maximum(abs(wanted.astype(float)), 5e-324))

    assert float(error.max()) < 2.0


@every_set
def test_special_values_are_libms(vectors: str) -> None:
    call = functions(vectors)
    x = np.array([0.0, np.inf, -np.inf, np.nan, 1e308, -1e308, 5e-324, 1.0])
    with np.errstate(all="ignore"):
        for name in FUNCTIONS:
            wanted = getattr(np, name)(x)
            found = call(name, x)
            assert (np.isnan(found) == np.isnan(wanted)).all(), name
            finite = ~np.isnan(wanted)
            assert found[finite] == pytest.approx(wanted[finite], rel=1e-15), name


def test_bits_do_not_depend_on_the_instructions() -> None:
    x = np.random.default_rng(1).normal(size=8000) * 10
    for name in FUNCTIONS:
        found = [functions(vectors)(name, x) for vectors in available()]
        assert all(np.array_equal(found[0], other, equal_nan=True) for other in found[1:]), name


@every_set
def test_libraries_for_lanes_keep_denormal_numbers(vectors: str) -> None:
    call = functions(vectors)

    assert call("sqrt", np.array([5e-324]))[0] > 0
    assert float(np.float64(2.3e-308) / 8) > 0
