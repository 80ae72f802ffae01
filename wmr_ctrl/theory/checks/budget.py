"""Work of a verdict, counted instead of timed, so that its limit is the same on every machine.

A unit is about 1 ms of one processor: the eigenvalues of a small loop, or a step of Newton's method
on a large one.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache, wraps
from threading import local
from typing import ParamSpec, TypeVar

from wmr_ctrl.core.errors import WmrError

OF_RUN = 2000.0
"""Work that the verdict on a run may take: about 2 s."""
OF_LAW = 20000.0
"""Work for each law where `wmr-ctrl check` compares all of them."""
OF_CORRIDOR = 20000.0
"""Work for a law's corridor over its whole run in `wmr-ctrl check`."""
LARGE = 100
"""States of a loop whose matrices take as long as everything else in an evaluation."""
P = ParamSpec("P")
T = TypeVar("T")


class OverBudgetError(WmrError):
    """A result needs more work than is allowed."""


class _Account(local):
    """Work spent by this thread, and its limit."""

    spent = 0.0
    most = math.inf


_account = _Account()


@contextmanager
def budget(most: float) -> Iterator[None]:
    """Context that raises OverBudgetError as soon as more work than ``most`` is spent."""
    before = _account.spent, _account.most
    _account.spent, _account.most = 0.0, most
    try:
        yield
    finally:
        _account.spent, _account.most = before


def spend(size: int, times: float = 1.0) -> None:
    """Record ``times`` evaluations with matrices of this ``size``."""
    _account.spent += times * (1 + (size / LARGE) ** 3)
    if _account.spent > _account.most:
        raise OverBudgetError("the answer takes more work than is allowed here.")


def counted(function: Callable[P, T]) -> Callable[P, T]:
    """Cache a function; a cached result is charged with the work that it once took.

    So the result of a check does not depend on which checks ran before.
    """

    @lru_cache(maxsize=64)
    def answered(*args: P.args, **kwargs: P.kwargs) -> tuple[T, float]:
        before = _account.spent
        return function(*args, **kwargs), _account.spent - before

    @wraps(function)
    def ask(*args: P.args, **kwargs: P.kwargs) -> T:
        before = _account.spent
        value, work = answered(*args, **kwargs)  # type: ignore[arg-type]  # can be hashed
        _account.spent = before
        spend(0, work)
        return value

    return ask
