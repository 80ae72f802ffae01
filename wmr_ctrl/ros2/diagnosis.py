"""Level and message of diagnostics, from flags and from other publishers."""

from collections.abc import Iterable, Sequence

from .clocks import BACK, FORTH, FROZEN
from .drive_core import (
    ARRIVED,
    JUMPED,
    MISSED,
    NEW_PATH,
    NO_ODOMETRY,
    NO_PATH,
    NOT_FINITE,
    STOPPED,
)

OK, WARN, ERROR = 0, 1, 2
TOO_FAST, NO_COMMAND, MORE_PARTS = "too-fast", "no-command", "other-parts"
NEAR, NO_DISTANCE = "near", "no-distance"
ERRORS = {TOO_FAST, "unsound", STOPPED, NOT_FINITE}
WARNINGS = {
    NO_COMMAND, NO_ODOMETRY, "bounds-left", BACK, FORTH, FROZEN, JUMPED, MISSED, NO_PATH,
    NEW_PATH, MORE_PARTS, NEAR, NO_DISTANCE, "limit-refused",
}  # fmt: skip
PASSING = {MISSED, BACK, FORTH, FROZEN, MORE_PARTS}
"""Flags of a moment, which diagnostics tell for a second and the log not at each change."""
TOLD = {ARRIVED}
"""Flags that are reported though they are no fault."""
LEASE = "a node that ended abruptly is listed until its lease ends, some 20 s"


def rivals(own: str, publishers: Sequence[str], topic: str) -> str:
    """Sentence on other publishers of the base's commands; "" without any.

    ``own`` is the node's full name, ``publishers`` those of all that the graph lists on ``topic``.
    """
    others = sorted({name for name in publishers if name != own})
    again = publishers.count(own) > 1
    if not (others or again):
        return ""
    named = [*others, *(["a second node of this one's own name"] if again else [])]
    return (
        f"other publishers on {topic}: {', '.join(named)}. The promise is void while one of them "
        f"sends; {LEASE}."
    )


def two_senders(publishers: Sequence[str], topic: str) -> str:
    """Sentence on several senders on one topic of a node; "" for one sender."""
    if len(publishers) < 2:
        return ""
    return (
        f"{len(publishers)} senders on {topic}: {', '.join(sorted(set(publishers)))}. What they "
        f"send is mixed: keep one, or a multiplexer such as twist_mux ({LEASE})."
    )


def judged(
    flags: Iterable[str], problem: str = "", rival: str = "", senders: str = ""
) -> tuple[int, str]:
    """Diagnostic level and message of an active node."""
    given = set(flags)
    for level, text in ((ERROR, problem), (ERROR, rival), (ERROR, _named(given & ERRORS)),
                        (WARN, _named(given & WARNINGS)), (WARN, senders)):  # fmt: skip
        if text:
            return level, text
    return OK, _named(given & TOLD) or "driving"


def grave(flags: Iterable[str]) -> tuple[str, ...]:
    """Flags that are logged when they change, errors first, without momentary ones."""
    given = set(flags)
    return (*sorted(given & ERRORS), *sorted(given & (WARNINGS | TOLD) - PASSING))


def _named(flags: Iterable[str]) -> str:
    return ", ".join(sorted(flags))
