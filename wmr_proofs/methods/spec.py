"""Proof methods as light values, so that claims load without the proof packages."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from fractions import Fraction
from functools import cache
from importlib import import_module
from importlib.metadata import packages_distributions, version
from typing import Any, ClassVar

from wmr_proofs.regions import Case
from wmr_proofs.statement import Statement

Point = Mapping[str, Any]


@dataclass(frozen=True)
class Finding:
    """Verdict (PROVED, REFUTED or OPEN), counts of cases or boxes, and an exact point.

    The point violates a refuted statement, and satisfies the hypotheses of a proved one (so that
    they are consistent).
    """

    verdict: str
    evidence: Mapping[str, Any] = field(default_factory=dict)
    point: Mapping[str, Fraction] | None = None


@dataclass(frozen=True)
class Method:
    """Base: ``decide`` loads the engine, ``module.function``, on first use."""

    ENGINE: ClassVar[str] = ""
    NAME: ClassVar[str] = ""
    TRUSTED: ClassVar[tuple[str, ...]] = ("flint",)
    NEEDS: ClassVar[tuple[str, ...]] = ("flint",)

    def decide(self, statement: Statement) -> Finding:
        """PROVED, REFUTED with an exact counterexample, or OPEN."""
        module, _, function = self.ENGINE.partition(".")
        engine = vars(import_module(f"wmr_proofs.methods.{module}"))[function]
        found: Finding = engine(statement, self)
        return found


@dataclass(frozen=True)
class Ring(Method):
    """Exact algebra over all cases.

    ``fixed`` decides conditions ``... < constant`` by hypothesis; ``log_lemma`` allows ln t <= t -
    1 as the only fact about the logarithm; ``spare`` is the number of generators for atoms;
    ``quick`` stops at the first case that an exact point refutes.
    """

    ENGINE: ClassVar[str] = "ring.decide"
    NAME: ClassVar[str] = "RING"

    cases: Sequence[Case] = (Case("all"),)
    fixed: Mapping[float, bool] = field(default_factory=dict)
    log_lemma: bool = False
    spare: int = 5
    quick: bool = False


@dataclass(frozen=True)
class Z3(Method):
    """z3 on the graph: its engines for the reals, one after the other.

    ``effort`` limits their total work on one statement, in millions of units, so that a result does
    not depend on the machine's load.  The default is about 30 s of a processor.  ``first`` names,
    for each question of the statement, the engine that answered it before, if any; it is called
    first.  For a statement with parts it may have such names for each of them.
    """

    ENGINE: ClassVar[str] = "smt.decide"
    NAME: ClassVar[str] = "Z3"
    TRUSTED: ClassVar[tuple[str, ...]] = ("z3",)
    NEEDS: ClassVar[tuple[str, ...]] = ("z3", "flint")

    effort: float = 60
    first: tuple[Any, ...] = ()
    points: Sequence[Point] = ()


@dataclass(frozen=True)
class Ball(Method):
    """Interval and ball arithmetic with branch and bound over ``box`` (rational bounds per input).

    ``float_mode`` encloses what IEEE double arithmetic computes for the same instructions;
    ``cuts_at`` are coordinates where boxes are split first; ``budget`` bounds the number of boxes.
    """

    ENGINE: ClassVar[str] = "ball.decide"
    NAME: ClassVar[str] = "INTERVAL"

    box: Mapping[str, tuple[Fraction, Fraction]] = field(default_factory=dict)
    float_mode: bool = False
    cuts_at: Mapping[str, Sequence[Fraction]] = field(default_factory=dict)
    budget: int = 20000
    split: Sequence[str] = ()


@dataclass(frozen=True)
class Table(Method):
    """Every point of a finite table, doubles or rationals, each in exact or 300-bit arithmetic."""

    ENGINE: ClassVar[str] = "point.decide_table"
    NAME: ClassVar[str] = "POINT"

    points: Callable[[], Sequence[Point]] = tuple


@dataclass(frozen=True)
class Refute(Method):
    """Exact points only: REFUTED by one of them, else OPEN."""

    ENGINE: ClassVar[str] = "point.decide_points"
    NAME: ClassVar[str] = "POINT"

    points: Sequence[Point] = ()


def described(value: Any) -> Any:
    """Fingerprint of a method for records, with regions and boxes, without limits of work."""
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (str, int)):
        return str(value)
    if isinstance(value, Case):
        return value.described()
    if isinstance(value, Method):
        told = [f.name for f in fields(value) if f.name not in ("first", "effort")]
        return [type(value).__name__, *((name, described(vars(value)[name])) for name in told)]
    if isinstance(value, Mapping):
        return [(str(key), described(item)) for key, item in value.items()]
    if isinstance(value, Sequence):
        return [described(item) for item in value]
    if callable(value):
        return described(value())
    return str(value)


def versions(method: Method) -> dict[str, str]:
    """Version of each package whose correctness a verdict of this method depends on."""
    return {name: _version(name) for name in method.NEEDS}


@cache
def _version(package: str) -> str:
    """Version of a package, from a slow search through all that is done once per process."""
    return version(packages_distributions()[package][0])


def rounds(method: Method) -> bool:
    """True if it encloses computed doubles, which depends on the C library's accuracy."""
    return isinstance(method, Ball) and method.float_mode


def named(method: Method) -> str:
    """Name of a method in the ledger."""
    return method.NAME + ", rounding included" * rounds(method)


def trusted(method: Method) -> tuple[str, ...]:
    """Packages whose correctness a verdict of this method depends on."""
    return (*method.TRUSTED, *["libm"] * rounds(method))
