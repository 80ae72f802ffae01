"""Symbols of claims, by name."""

from collections.abc import Iterator

import casadi as ca

from .relation import Expressions, Relations
from .statement import Statement


class Symbols(dict[str, ca.SX]):
    """Scalar symbols by name, ``t["x"]`` or ``t.x``."""

    def __getattr__(self, name: str) -> ca.SX:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None

    def __or__(self, more: Expressions) -> "Symbols":  # type: ignore[override]
        return Symbols({**self, **more})

    def __ror__(self, more: Expressions) -> "Symbols":  # type: ignore[override]
        return Symbols({**more, **self})


class Named(Expressions):
    """Base of a setting that is the table of its ``symbols``, which are attributes, too.

    ``always`` are goals of each of its statements.
    """

    symbols: Symbols
    always: Relations = ()

    def __getitem__(self, name: str) -> ca.SX:
        return self.symbols[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.symbols)

    def __len__(self) -> int:
        return len(self.symbols)

    def __or__(self, more: Expressions) -> Symbols:
        return self.symbols | more

    def __getattr__(self, name: str) -> ca.SX:
        if name == "symbols":
            raise AttributeError(name)
        return getattr(self.symbols, name)

    def states(
        self,
        *goals: Relations,
        given: Relations = (),
        cuts: Expressions | None = None,
        more: Expressions | None = None,
    ) -> Statement:
        """The statement about these symbols, and ``more``."""
        return Statement(self.symbols | (more or {}), (goals, self.always), given, cuts or {})


def symbols(names: str, fixed: str = "") -> Symbols:
    """Fresh scalar symbols by name; those in ``fixed`` are parameters for the compiler."""
    known = set(fixed.split())
    return Symbols({n: ca.SX.sym(f"p.{n}" if n in known else n) for n in names.split()})


def column(name: str, size: int, fixed: bool = False) -> Symbols:
    """Fresh scalar symbols name1 to name<size>; ``fixed`` makes them parameters."""
    names = " ".join(f"{name}{i}" for i in range(1, size + 1))
    return symbols(names, names if fixed else "")


def exchanged(expr: ca.SX, old: Expressions, new: Expressions) -> ca.SX:
    """The expression with the symbols ``old`` replaced by those of equal name in ``new``."""
    both = [(old[name], new[name]) for name in old if name in new]
    return ca.substitute(expr, *(ca.vertcat(*side) for side in zip(*both, strict=True)))


def stacked(table: Expressions, name: str, size: int) -> ca.SX:
    """Column of name1 to name<size> out of a table."""
    return ca.vertcat(*(table[f"{name}{i}"] for i in range(1, size + 1)))
