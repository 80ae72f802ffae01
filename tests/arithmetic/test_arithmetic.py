"""Elementary functions: accuracy, special values, and equality of lanes and single numbers."""

import itertools
import math
import re
import tomllib

import mpmath
import numpy as np
import pytest

from tests.arithmetic.functions import EVERY, PAIRS, called, hashes, library
from wmr_ctrl.codegen.build import flags_of, vector_sets
from wmr_ctrl.codegen.dialect import HEADER
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.toolchain import find_toolchain

DRAWS = 300
STATED = (runtime_dir() / HEADER).read_text("utf-8").split("in the last place: ")[1]
LIMITS = {
    name: float(units) if units.isdigit() else 0.501
    for names, units in re.findall(
        r"([a-z]\w*(?:,\s+\w+)*) (\d|none but rounding)", STATED.split("Coefficients")[0]
    )
    for name in re.split(r",\s+", names)
}
"""Units in the last place, as the header states them."""
RANGES = tomllib.loads("""
    [uniform]
    exp = [[-745.0, 709.7], [-701.0, -699.0], [699.0, 701.0], [-1.0, 1.0]]
    expm1 = [[-60.0, 60.0], [-1.5, 1.5], [-0.36, 0.36], [55.0, 57.0], [600.0, 709.7]]
    log = [[0.5, 2.0], [0.999, 1.001]]
    log1p = [[-0.99, 3.0], [-0.5, 0.5]]
    sin = [[-10.0, 10.0], [-1000.0, 1000.0], [999.0, 1001.0]]
    cos = [[-10.0, 10.0], [-1000.0, 1000.0], [999.0, 1001.0]]
    tan = [[-10.0, 10.0], [-1000.0, 1000.0], [999.0, 1001.0]]
    tanh = [[-3.0, 3.0], [0.6, 0.65], [18.0, 20.0]]
    sinh = [[-3.0, 3.0], [-710.4, 710.4], [0.99, 1.01], [699.0, 701.0]]
    cosh = [[-3.0, 3.0], [-710.4, 710.4], [699.0, 701.0]]
    asin = [[-1.0, 1.0], [0.49, 0.51], [0.97, 1.0]]
    acos = [[-1.0, 1.0], [0.49, 0.51], [-0.51, -0.49], [0.97, 1.0]]
    atan = [[-5.0, 5.0], [0.43, 0.44], [0.68, 0.69], [1.18, 1.19], [2.43, 2.44]]
    sqrt = [[0.0, 4.0]]

    [powers_of_ten]  # both signs where the function takes them
    exp = [[-20.0, 0.0]]
    expm1 = [[-20.0, 0.0]]
    log = [[-323.0, -308.0], [-307.0, 308.0]]
    log1p = [[-20.0, 300.0]]
    sin = [[-20.0, 0.0], [3.0, 308.0]]
    cos = [[-20.0, 0.0], [3.0, 308.0]]
    tan = [[-20.0, 0.0], [3.0, 308.0]]
    tanh = [[-20.0, 1.3]]
    sinh = [[-20.0, 0.0]]
    cosh = [[-20.0, 0.0]]
    asin = [[-20.0, -0.01]]
    acos = [[-20.0, -0.01]]
    atan = [[-20.0, 20.0]]
    sqrt = [[-323.0, 308.0]]
""")
UNIFORM, POWERS = RANGES["uniform"], RANGES["powers_of_ten"]
SPECIAL = np.array(
    [sign * size for sign in (1.0, -1.0) for size in (
        0.0, 5e-324, 1e-310, 2.2250738585072014e-308, 1e-20, 0.5, 0.5 + 2**-52, 0.625, 1.0, 1.5,
        np.pi / 2, 2.0, 3.0, 19.1, 999.9999, 1000.0, 709.78, 709.79, 710.475, 745.0, 746.0,
        4503599627370495.5, 2.0**52, 2.0**53, 2.0**53 + 2, 1e300, 1.7976931348623157e308,
        math.inf, math.nan,
    )]
)  # fmt: skip
NUMPY = {
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2, "pow": np.power,
    "abs": np.fabs, "exp_many": np.exp, "sin_of_both": np.sin, "cos_of_both": np.cos,
    "one_nan": np.positive, "sign": lambda a: np.where(a == 0, a, np.sign(a)),
    "min": lambda a, b: np.where(a < b, a, b), "max": lambda a, b: np.where(a > b, a, b),
}  # fmt: skip
"""Functions of other names there."""
SETS = {item.name: item for item in vector_sets()}


def inputs(name):
    draw = np.random.default_rng(0)
    both = [1.0] if name in ("log", "log1p", "sqrt") else [1.0, -1.0]
    parts = [draw.uniform(low, high, DRAWS) for low, high in UNIFORM[name]]
    parts += [draw.choice(both, DRAWS) * 10 ** draw.uniform(*ends, DRAWS) for ends in POWERS[name]]
    if name in ("sin", "cos", "tan"):
        zeros = np.arange(1, 640, 7) * (math.pi / 2)
        parts += [zeros, np.nextafter(zeros, 0.0), -np.nextafter(zeros, np.inf)]
    return np.concatenate(parts)


def pairs(name):
    draw = np.random.default_rng(0)

    def powers(*ends):
        return np.concatenate([10 ** draw.uniform(low, high, DRAWS) for low, high in ends])

    if name == "pow":
        near_one = 1 + draw.choice([1, -1], DRAWS) * powers((-10, -1))
        bases = draw.uniform(0, 5, DRAWS), powers((-300, 300), (-323, -308)), near_one
        exponents = draw.uniform(-400, 400, DRAWS), draw.uniform(-1, 1, 2 * DRAWS), powers((2, 9))
        return np.concatenate(bases), np.concatenate(exponents)
    ranges = [(-5, 5), (-300, 300), (-323, -300), (300, 308)]
    sides = [powers(*ranges) for _ in range(2)]
    return tuple(side * draw.choice([1.0, -1.0], len(side)) for side in sides)


def error(found, wanted):
    """Error of a result, in units in its last place."""
    rounded = float(wanted)
    if math.isinf(rounded) or math.isinf(found):
        return 0.0 if rounded == found else math.inf
    return float(abs(mpmath.mpf(found) - wanted) / math.ulp(rounded))


def worst(name, given, precision=120):
    truth = getattr(mpmath, {"pow": "power"}.get(name, name))
    found = called(name, *given, of=library())
    with mpmath.workprec(precision):
        return max(
            error(float(one), truth(*(mpmath.mpf(float(item)) for item in row)))
            for one, row in zip(found, zip(*given, strict=True), strict=True)
        )


@pytest.mark.parametrize("name", [*UNIFORM, "atan2", "hypot", "pow"])
def test_functions_are_as_right_as_the_header_says(name):
    assert worst(name, (inputs(name),) if name in UNIFORM else pairs(name)) <= LIMITS[name]


@pytest.mark.parametrize("name", ["sin", "cos", "tan"])
def test_angles_of_any_size_are_reduced_exactly(name):
    """Also next to multiples of pi/2; the first angle is the double nearest to any multiple."""
    given = np.array([6381956970095103 * 2.0**797, 1e300, 1e22, 2.0**1023, -1.7976931348623157e308])

    assert worst(name, (given,), precision=1300) <= LIMITS[name]


@pytest.mark.parametrize("name", EVERY)
def test_special_values_are_the_c_librarys(name):
    """Including the signs of zeros."""
    rows = itertools.product(SPECIAL, SPECIAL) if name in PAIRS else zip(SPECIAL, strict=True)
    given = [np.array(column) for column in zip(*rows, strict=True)]
    found = called(name, *given, of=library())
    with np.errstate(all="ignore"):
        wanted = (NUMPY.get(name) or getattr(np, name))(*given)
    ends = ~np.isfinite(wanted) | (wanted == 0)

    assert np.array_equal(found[ends], wanted[ends], equal_nan=True)
    assert found[~ends] == pytest.approx(wanted[~ends], rel=1e-15, abs=5e-324)
    known = ~np.isnan(wanted)
    assert np.array_equal(np.signbit(found[known]), np.signbit(wanted[known]))


def test_every_nan_becomes_the_same():
    bits = np.array([0x7FF8000000000001, 0xFFF8000000000000, 0x7FF0000000000001], dtype=np.uint64)
    found = called("one_nan", bits.view(float), of=library())

    assert (found.view(np.uint64) == 0x7FF8000000000000).all()


@pytest.mark.parametrize("vectors", SETS)
@pytest.mark.slow
def test_lanes_have_the_bits_of_numbers(vectors):
    if SETS[vectors].lanes > library().most_lanes():
        pytest.skip(f"NOT RUN: this processor has no {vectors}")
    toolchain = find_toolchain()
    lanes = library(toolchain, tuple(flags_of(SETS[vectors], toolchain)))

    found = hashes(lanes)
    assert found == hashes(library())
    # The functions of both are sine and cosine, and exp_many is exp.
    assert (found["sin_of_both"], found["cos_of_both"]) == (found["sin"], found["cos"])
    assert len(set(found.values())) == len(EVERY) - 3
