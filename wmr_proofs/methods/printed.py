"""Terms as SMT-LIB 2 text, written here and not by z3, so that no version of z3 changes it.

A term that is read more than once has a name, ``$1``, ``$2`` and so on in the order of first use.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import z3

SAME = ["+", "-", "*", "/", "=", "distinct", "<", "<=", ">", ">=", "not", "and", "or", "=>"]
OPERATIONS = {"if": "ite", **dict(zip(SAME, SAME, strict=True))}
"""The language's word for what z3 names so."""
COMMANDS = frozenset({"assert", "echo", "exit", "pop", "push", "reset"})
"""Words of the language that may be a symbol's name here; z3 alone reads them as one."""


def printed(asserted: Sequence[Any], inputs: Mapping[str, Any]) -> str:
    """All assertions, with the symbols that they read."""
    readers = Counter[int]()
    ordered = list(_in_order(asserted, readers))
    symbols = {term.decl().name(): _symbol(term) for term in ordered if _is_symbol(term)}
    known = [name for name in inputs if name in symbols]
    names = [*known, *sorted(set(symbols) - set(known))]
    lines = ["(set-logic QF_NRA)", *(f"(declare-fun {symbols[name]} () Real)" for name in names)]
    texts: dict[int, str] = {}
    roots = Counter(term.get_id() for term in asserted)
    count = 0
    for term in ordered:
        key = term.get_id()
        texts[key] = _text(term, texts)
        if term.num_args() and readers[key] > 1:
            count += 1
            sort = "Bool" if z3.is_bool(term) else "Real"
            lines.append(f"(define-fun ${count} () {sort} {texts[key]})")
            texts[key] = f"${count}"
        lines += [f"(assert {texts[key]})"] * roots[key]
    return "\n".join([*lines, "(check-sat)", ""])


def _in_order(asserted: Sequence[Any], readers: Counter[int]) -> Iterator[Any]:
    """Each term once, after all terms that it reads; ``readers`` counts its readers."""
    done = set[int]()
    for root in asserted:
        readers[root.get_id()] += 1
        stack = [(root, False)]
        while stack:
            term, ready = stack.pop()
            if ready:
                yield term
                continue
            if term.get_id() in done:
                continue
            done.add(term.get_id())
            stack.append((term, True))
            for part in reversed(term.children()):
                readers[part.get_id()] += 1
                stack.append((part, False))


def _is_symbol(term: Any) -> bool:
    return bool(z3.is_const(term) and term.decl().kind() == z3.Z3_OP_UNINTERPRETED)


def _symbol(term: Any) -> str:
    name = term.decl().name()
    return f"|{name} (symbol)|" if name in COMMANDS else f"|{name}|"


def _text(term: Any, texts: Mapping[int, str]) -> str:
    if z3.is_rational_value(term):
        return _number(term.as_fraction())
    if _is_symbol(term):
        return _symbol(term)
    if not term.num_args():
        return "true" if z3.is_true(term) else "false"
    parts = [texts[part.get_id()] for part in term.children()]
    return f"({' '.join([OPERATIONS[term.decl().name()], *parts])})"


def _number(value: Fraction) -> str:
    size = f"{abs(value.numerator)}.0"
    if value.denominator != 1:
        size = f"(/ {size} {value.denominator}.0)"
    return f"(- {size})" if value < 0 else size
