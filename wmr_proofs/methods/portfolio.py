"""z3's engines for the reals as a portfolio: each is called by name, long attempts last."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from time import monotonic
from typing import Any

import z3

from .spec import Z3

ENGINES: Mapping[str, Callable[[z3.Context], Any]] = {
    "z3's order": lambda context: _by_cells(context),
    "cases": lambda context: _by_cases(context, random_seed=0),
    "Brown's order": lambda context: _by_cells(context, variable_ordering_strategy=1),
    "triangular order": lambda context: _by_cells(context, variable_ordering_strategy=2),
    "order as posed": lambda context: _by_cells(context, reorder=False),
    "cases anew": lambda context: _by_cases(context, random_seed=1),
    "cases, a third time": lambda context: _by_cases(context, random_seed=2),
    "cases, a fourth time": lambda context: _by_cases(context, random_seed=3),
    "cases, a fifth time": lambda context: _by_cases(context, random_seed=4),
}
"""z3's engines for the reals, each asked by name: cells of the space, by the order in which its
variables are taken, and case distinction over linear arithmetic, whose luck with one seed says
little about the next.  Left to itself, z3 goes from one to the next by the clock: a busy machine
ends in another one, which may never come back."""
ATTEMPTS = ((2.0, 5.0), (15.0, 30.0), (60.0, 120.0))
"""Rounds of attempts with each engine: most work [millions of units], and seconds of the clock.

The work decides.  The clock ends an attempt that z3 does not count, which no entry needs.
"""
KNOWN = ATTEMPTS[1]
"""Attempt with the engine that answered the same question before."""
WEIGHT = {name: 6.0 if name.startswith("cases") else 1.0 for name in ENGINES}
"""Units that one of z3's counts for: one of case distinction takes some six times as long.  With
it 60 million units are about 30 s of a processor."""


@dataclass(frozen=True)
class Answer:
    """sat, unsat or unknown; a model if there is one; the engine, empty for a quick first one."""

    word: str
    model: Any = None
    engine: str = ""


class Portfolio:
    """All questions on one statement, with a common ``effort``.

    ``spent``: millions of units so far; ``tried``: engines that were called, in order.
    """

    def __init__(self, method: Z3) -> None:
        self.method, self.spent, self.tried = method, 0.0, dict[str, None]()

    def ask(self, terms: list[Any], place: int = 0) -> Answer:
        """Answer of the first engine that finds one; ``place``: the question's index."""
        over = set[str]()
        for engine, size in self._attempts(place):
            if engine in over or self._left <= 0:
                continue
            before, begun = self.spent, monotonic()
            answer, model = self.attempt(engine, terms, size)
            if answer != z3.unknown:
                first = engine == next(iter(ENGINES)) and size == ATTEMPTS[0]
                return Answer(str(answer), model, "" if first else engine)
            soon = monotonic() - begun < 0.9 * size[1]  # else a busy machine's clock ended it
            if soon and self.spent - before < 0.9 * size[0]:  # the engine has no more to try
                over.add(engine)
        return Answer("unknown")

    def other_models(self, terms: list[Any]) -> Iterator[Any]:
        """The model of each engine that finds one quickly."""
        for engine in ENGINES:
            if self._left > 0:
                _, model = self.attempt(engine, terms, ATTEMPTS[0])
                if model is not None:
                    yield model

    def attempt(self, engine: str, terms: list[Any], size: tuple[float, float]) -> tuple[Any, Any]:
        """z3's answer and model, in a separate context, so that each attempt is reproducible.

        ``size``: most work [millions of units] and seconds.
        """
        context, (work, seconds) = z3.Context(), size
        solver = ENGINES[engine](context)
        counts = 1e6 / WEIGHT[engine]
        solver.set("rlimit", max(1, int(counts * min(work, self._left))))
        solver.set("timeout", int(1000 * seconds))
        solver.add(*(term.translate(context) for term in terms))
        answer = solver.check()
        self.spent += dict(iter(solver.statistics())).get("rlimit count", 0) / counts
        self.tried[engine] = None
        return answer, solver.model() if answer == z3.sat else None

    @property
    def _left(self) -> float:
        return self.method.effort - self.spent

    def _attempts(self, place: int) -> Iterator[tuple[str, tuple[float, float]]]:
        """Engines and sizes: first the one that answered before, then all, with growing limits."""
        yield from ((name, KNOWN) for name in self.method.first[place : place + 1] if name)
        yield from ((name, size) for size in ATTEMPTS for name in ENGINES)


def _by_cells(context: z3.Context, **options: int) -> Any:
    return z3.With(z3.Tactic("qfnra-nlsat", context), **options).solver()


def _by_cases(context: z3.Context, **options: int) -> Any:
    solver = z3.SimpleSolver(context)
    solver.set(**options)
    return solver
