"""z3's engines for the reals as a portfolio: each asked by name, the patient attempts last."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf
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
PATIENCE = (0.5, 4, 30, 240)
"""Seconds of the clock for the attempts of each engine: what one closes at once, the other may work
on without an end, and some of its steps count little in z3's own units.  An attempt goes the same
way each time and on every machine, so that a slow one needs a longer attempt, not another verdict;
what closes now closes in seconds."""


@dataclass(frozen=True)
class Answer:
    """sat, unsat or unknown; a model where there is one; the engine, unless the first at once."""

    word: str
    model: Any = None
    engine: str = ""


def ask(terms: list[Any], method: Z3, place: int = 0) -> Answer:
    """Answer of one of z3's engines within the method's effort; ``place`` of the question."""
    tried = dict.fromkeys(ENGINES, 0.0)
    for engine, patience in _attempts(method, method.first[place : place + 1]):
        if patience <= tried[engine]:
            continue
        tried[engine], started = patience, monotonic()
        answer, model = attempt(engine, terms, method.effort, patience)
        if answer != z3.unknown:
            easy = engine == next(iter(ENGINES)) and patience == PATIENCE[0]
            return Answer(str(answer), model, "" if easy else engine)
        if monotonic() - started < 0.9 * patience:  # it has no more to try, or no more effort
            tried[engine] = inf
    return Answer("unknown")


def _attempts(method: Z3, known: Sequence[str]) -> Iterator[tuple[str, float]]:
    """Engines and seconds: the one that closed it before, to the end, then all, ever longer."""
    longest = [patience for patience in PATIENCE if patience <= method.seconds]
    yield from ((engine, longest[-1]) for engine in known if engine in ENGINES)
    yield from ((engine, patience) for patience in longest for engine in ENGINES)


def other_models(terms: list[Any], method: Z3) -> Iterator[Any]:
    """The model of each engine that finds one soon."""
    for engine in ENGINES:
        _, model = attempt(engine, terms, method.effort, PATIENCE[1])
        if model is not None:
            yield model


def attempt(engine: str, terms: list[Any], effort: int, patience: float) -> tuple[Any, Any]:
    """z3's answer and model; in a context of its own, so that it goes the same way each time."""
    context = z3.Context()
    solver = ENGINES[engine](context)
    solver.set("rlimit", 1_000_000 * effort)
    solver.set("timeout", int(1000 * patience))
    solver.add(*(term.translate(context) for term in terms))
    answer = solver.check()
    return answer, solver.model() if answer == z3.sat else None


def _by_cells(context: z3.Context, **options: int) -> Any:
    return z3.With(z3.Tactic("qfnra-nlsat", context), **options).solver()


def _by_cases(context: z3.Context, **options: int) -> Any:
    solver = z3.SimpleSolver(context)
    solver.set(**options)
    return solver
