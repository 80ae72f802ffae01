"""Claim: one line of the ledger before it is checked; a file writes its claims as functions.

The function builds the relations; the first paragraph of its docstring is the claim's wording
(without its final period), the second its meaning for a robot, the last its hypotheses, in which a
name in braces stands for a text of `shared.toml`:

    claim = Claims(by=Z3())

    @claim("guard.anchor")
    def anchor(mutation: Mutation) -> Statement:
        '''|clip(0, lo, hi)| <= FB.

        The force of least effort is within the brake cap.

        Given: {SIGNS}, 2 nbar <= u1.
        '''
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from inspect import signature
from typing import Any, TypeVar

from wmr_ctrl.core.data import data

from .methods.spec import Z3, Method
from .statement import Statement, joined

SHARED = data(__package__, "shared.toml")
"""Texts that hypotheses share, by name."""
PRINTED, CORRECTED, OURS = "printed", "corrected", "ours"
Written = TypeVar("Written", bound=Callable[..., Statement | None])


class Mutation(float):
    """Sign of a statement: 1 as claimed, -1 with one sign or constant altered.

    The method that proves a claim must refute its mutation.
    """

    def __call__(self, claimed: Any, mutated: Any) -> Any:
        """The claimed value, or the mutated one."""
        return claimed if self > 0 else mutated

    def __neg__(self) -> Mutation:
        """The opposite sign, for a claim that is another's mutation."""
        return Mutation(-float(self))


BY_Z3 = Z3()
CLAIMED, MUTATED = Mutation(1.0), Mutation(-1.0)


@dataclass(frozen=True)
class Claim:
    """A claim, its meaning for a robot, and its method of proof.

    ``statement(mutation)`` builds the claim's relations from the product's graphs.  A claim without
    statement has a given verdict (HAND or OPEN).  ``premises`` names the entries that it depends
    on.
    """

    id: str
    equations: tuple[int, ...]
    form: str
    claim: str
    meaning: str
    hypotheses: str = ""
    statement: Callable[[Mutation], Statement] | None = None
    method: Method | None = None
    verdict: str = ""
    premises: tuple[str, ...] = ()
    theme: str = ""

    def words(self) -> dict[str, Any]:
        """The claim's texts in its ledger entry."""
        names = ("equations", "form", "claim", "meaning", "hypotheses", "premises", "theme")
        return {name: vars(self)[name] for name in names}


@dataclass
class Claims:
    """The claims of one file in their order, and their defaults."""

    by: Method | str | Callable[..., Method] = BY_Z3
    form: str = OURS
    given: str = ""
    meaning: str = ""
    premises: str = ""
    listed: list[Claim] = field(default_factory=list)

    def __call__(
        self,
        id: str,
        equations: tuple[int, ...] = (),
        *,
        given: str | None = None,
        by: Method | str | Callable[..., Method] | None = None,
        form: str = "",
        premises: str | None = None,
        over: Iterable[Mapping[str, Any]] = (),
        each: Mapping[str, Mapping[str, Any]] = {},
        **values: Any,
    ) -> Callable[[Written], Written]:
        """Decorator that enters a function as the claim ``id`` about these equations of the paper.

        ``given``: the hypotheses as text if the docstring has none.  ``by``: a method or a given
        verdict.  ``premises``: ids.  ``values`` replace their names in braces in every text, and in
        each other.  They are also passed to the function (and to ``by``) if it has such arguments.
        ``over``:
        one claim for each of these tables, which may have their own ``equations`` and ``each``.
        ``each``: one claim of several statements, by name, one for each of these tables.
        """
        way = by or self.by

        def enter(function: Written) -> Written:
            for table in over or (values,):
                known = {**SHARED, **table}
                text = partial(_filled, values=known if table else {})
                claimed, _, rest = (function.__doc__ or "").partition("\n\n")
                meaning, _, told = rest.partition("Given: ")
                told = told or (self.given if given is None else given)
                method = _asked(way, table)() if callable(way) else way
                engine = method if isinstance(method, Method) else None
                called: Callable[..., Statement] = _asked(function, table)
                if parts := table.get("each", each):
                    called = Each(function, {key: {**table, **row} for key, row in parts.items()})
                self.listed.append(
                    Claim(
                        text(id), table.get("equations", equations), form or self.form,
                        text(claimed).removesuffix("."),
                        text(meaning.strip() or self.meaning),
                        _filled(told, known).removesuffix("."),
                        called if engine else None, engine, "" if engine else str(method),
                        tuple(text(self.premises if premises is None else premises).split()),
                    )
                )  # fmt: skip
            return function

        return enter


@dataclass(frozen=True)
class Each:
    """Statement of a claim that has several: the function's statement for each of these tables, by
    name.
    """

    function: Callable[..., Any]
    tables: Mapping[str, Mapping[str, Any]]

    def __call__(self, mutation: Mutation) -> Statement:
        """All of the statements as one."""
        called = {key: _asked(self.function, table) for key, table in self.tables.items()}
        return joined({key: call(mutation) for key, call in called.items()})


def rows(**columns: Sequence[Any]) -> tuple[dict[str, Any], ...]:
    """Tables for ``over``, one per position of the columns: for both axes, or both directions."""
    places = zip(*columns.values(), strict=True)
    return tuple(dict(zip(columns, values, strict=True)) for values in places)


def _filled(text: str, values: Mapping[str, Any]) -> str:
    """The text in one line, with names in braces replaced by values, recursively."""
    line = " ".join(text.split())
    while values and "{" in line:
        line = line.format(**values)
    return line


def _asked(function: Callable[..., Any], values: Mapping[str, Any]) -> Callable[..., Any]:
    """The function with the values of its arguments bound."""
    named = signature(function).parameters
    kept = {name: value for name, value in values.items() if name in named}
    return partial(function, **kept) if kept else function
