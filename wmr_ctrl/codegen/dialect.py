"""C text of an operation: in doubles for one robot, or in vectors for lanes of robots."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import casadi as ca

from wmr_ctrl.core.errors import ArgumentError

_OF_ONE = (
    "sign", "sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tan", "asin", "acos", "atan",
    "sinh", "cosh", "tanh", "floor", "ceil",
)  # fmt: skip
_OF_TWO = ("copysign", "atan2", "hypot", "pow")
"""Functions of arithmetic.h that are called as CasADi calls them."""
_NUMBERS = {
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}",
    ca.OP_INV: "1.0 / {0}",
    ca.OP_FMIN: "wmr_min({0}, {1})",
    ca.OP_FMAX: "wmr_max({0}, {1})",
    ca.OP_FABS: "wmr_abs({0})",
    ca.OP_CONSTPOW: "wmr_pow({0}, {1})",
    **{vars(ca)[f"OP_{name.upper()}"]: f"wmr_{name}({{0}})" for name in _OF_ONE},
    **{vars(ca)[f"OP_{name.upper()}"]: f"wmr_{name}({{0}}, {{1}})" for name in _OF_TWO},
}
_COMPARISONS = {
    ca.OP_LT: "{0} < {1}",
    ca.OP_LE: "{0} <= {1}",
    ca.OP_EQ: "{0} == {1}",
    ca.OP_NE: "{0} != {1}",
}
_MASKS = {op: f"wmr_mask({text})" for op, text in _COMPARISONS.items()}
_JOINED = {ca.OP_AND: "{0} && {1}", ca.OP_OR: "{0} || {1}", ca.OP_NOT: "!{0}"}
_JOINED_MASKS = {ca.OP_AND: "{0} & {1}", ca.OP_OR: "{0} | {1}", ca.OP_NOT: "wmr_not({0})"}
TRUTHS = frozenset({ca.OP_AND, ca.OP_OR, ca.OP_NOT})
"""Operations whose operands are truth values."""


@dataclass(frozen=True)
class Dialect:
    """Types and patterns of one way to write C, and the header that has its functions.

    ``exp_batch``: independent exponentials are computed side by side, in arrays of multiples of
    this size; 0: one by one.  ``packs_stores``: single operations that fill an array are written
    four at a time.  ``pairs_sines``: sine and cosine of one angle are one call.  ``plain``: every
    operation is one line, without loops and branches.
    """

    header: str
    real: str
    truth: str
    patterns: Mapping[int, str]
    lanes: bool = False
    exp_batch: int = 0
    packs_stores: bool = False
    pairs_sines: bool = False
    plain: bool = False

    def pattern(self, op: int) -> str:
        """The C expression of an operation, with {0} and {1} for its operands.

        Raises ArgumentError for an operation that our graphs never contain.
        """
        if op not in self.patterns:
            name = next(k for k, code in vars(ca).items() if k.startswith("OP_") and code == op)
            known = ", ".join(dict.fromkeys((*_OF_ONE, *_OF_TWO, "fmin", "fmax", "fabs")))
            raise ArgumentError(
                f"the graph of a law, reference or effect has CasADi's operation {name[3:].lower()}"
                f", of which there is no C. Write it with arithmetic, if_else and {known}."
            )
        return self.patterns[op]

    def number(self, value: float) -> str:
        """A constant."""
        text = repr(float(value))
        named = {"inf": "WMR_INF", "-inf": "(-WMR_INF)", "nan": "WMR_NAN"}
        text = named.get(text, f"({text})" if text.startswith("-") else text)
        return f"wmr_all({text})" if self.lanes else text

    def choice(self, condition: str, yes: str, no: str, *, truths: bool = False) -> str:
        """A choice between two numbers, or between two truth values."""
        if self.lanes:
            return f"wmr_{'pick' if truths else 'choose'}({condition}, {yes}, {no})"
        return f"{condition} ? {yes} : {no}"

    def as_real(self, truth: str) -> str:
        """A truth value as the number 1 or 0."""
        return f"wmr_number({truth})" if self.lanes else truth

    def as_truth(self, real: str) -> str:
        """A number as a truth value: whether it is not 0."""
        return f"wmr_truth({real})" if self.lanes else f"({real} != 0)"


HEADER = "arithmetic.h"
"""The functions of both dialects, in fmu/runtime: an element's bits are the same in both."""
_SCALAR = MappingProxyType(_NUMBERS | _COMPARISONS | _JOINED)
_VECTOR = MappingProxyType(_NUMBERS | _MASKS | _JOINED_MASKS)
SCALAR = Dialect(HEADER, "double", "int", _SCALAR, exp_batch=8, packs_stores=True)
PLAIN = Dialect(HEADER, "double", "int", _SCALAR, plain=True)
"""Quick to write, for functions whose speed does not matter."""
LANES = Dialect(HEADER, "wmr_v", "wmr_m", _VECTOR, lanes=True, exp_batch=1, pairs_sines=True)
