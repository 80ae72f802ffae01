"""All claims on two processes, longest first, with progress."""

import gc
import os
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from fnmatch import fnmatchcase
from functools import lru_cache
from multiprocessing import get_context

from wmr_ctrl.errors import UnknownNameError
from wmr_ctrl.proofs.ledger import COMMITTED, Entry, Ledger, load, stale

PROCESSES = 2
LEAST_COST = 0.1
"""Seconds that an entry is taken to cost at least; what is new is taken to cost five of these."""
GLOB = frozenset("*?[")
Progress = Callable[[float, Entry], None]


def prove(
    only: Iterable[str] = (),
    progress: Progress | None = None,
    processes: int = PROCESSES,
    anew: bool = False,
) -> Ledger:
    """Check the claims that ``only`` names (all by default): ids, their beginnings, or globs.

    ``progress(share, entry)`` is called after each, with the share of the whole cost that is done.
    ``anew``: nothing is taken from the committed ledger (`check` says what is otherwise).
    UnknownNameError where something in ``only`` names no entry.
    """
    ids = selected(tuple(only))
    checked = {entry.id: entry for entry in _run(ids, progress, processes, anew)}
    return Ledger(tuple(checked[key] for key in ids))


def selected(only: Sequence[str]) -> list[str]:
    """Ids of the claims that are asked for, in the ledger's order."""
    from wmr_ctrl.proofs.claims import all_claims

    known = [claim.id for claim in all_claims()]
    for asked in only:
        if not any(_matches(key, asked) for key in known):
            raise UnknownNameError(
                "entry",
                asked,
                known,
                "An entry's beginning up to a dot selects all of its kind, and so does a pattern "
                "such as 'guard.*'.",
            )
    return [key for key in known if not only or any(_matches(key, asked) for asked in only)]


def check_id(key: str, anew: bool = False) -> Entry:
    """One entry, in whatever process."""
    from wmr_ctrl.proofs.check import check
    from wmr_ctrl.proofs.claims import all_claims

    claim = next(claim for claim in all_claims() if claim.id == key)
    return check(claim, None if anew else _committed().get(key))


@lru_cache(maxsize=1)
def _committed() -> dict[str, Entry]:
    return load().by_id() if COMMITTED.exists() else {}


def hashes(ids: Iterable[str] | None = None) -> dict[str, str]:
    """Hash of each claim's graph (of those named, or of all) as the product is now."""
    from wmr_ctrl.proofs.check import graph_hash
    from wmr_ctrl.proofs.claims import all_claims

    asked = None if ids is None else set(ids)
    claims = (claim for claim in all_claims() if asked is None or claim.id in asked)
    return {claim.id: graph_hash(claim) for claim in claims}


def stale_entries() -> list[str] | None:
    """Ids whose graph has changed since the ledger was committed; None without the extras."""
    try:
        return stale(hashes(), load())
    except ImportError:
        return None


def _matches(key: str, asked: str) -> bool:
    if GLOB & set(asked):
        return fnmatchcase(key, asked)
    return key == asked or key.startswith(asked + ".")


def _run(ids: Sequence[str], progress: Progress | None, processes: int, anew: bool) -> list[Entry]:
    checked: list[Entry] = []
    costs, done = _costs(ids), 0.0
    for entry in _entries(sorted(ids, key=lambda key: -costs[key]), processes, anew):
        checked.append(entry)
        done += costs[entry.id]
        if progress:
            progress(done / sum(costs.values()), entry)
    return checked


def _entries(ids: Sequence[str], processes: int, anew: bool) -> Iterable[Entry]:
    if processes < 2 or len(ids) < 2:
        yield from (check_id(key, anew) for key in ids)
        return
    context = get_context("spawn")
    with ProcessPoolExecutor(processes, context, _begin, (os.getpid(),)) as pool:
        for future in as_completed([pool.submit(_checked, key, anew) for key in ids]):
            yield future.result()


def _begin(parent: int) -> None:
    """Set up a process that works: it ends with its parent, and its solvers know one thread only.

    What they no longer need is collected between two entries: a collection in the thread that
    watches the parent would free a solver's terms while the solver works on them.
    """
    gc.disable()
    follow_parent(parent)


def _checked(key: str, anew: bool) -> Entry:
    entry = check_id(key, anew)
    gc.collect()
    gc.freeze()  # modules and graphs stay: the next collection need not walk them
    return entry


def follow_parent(parent: int) -> None:
    """End this process when ``parent`` is gone, however it went: a solver would work on for it."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _costs(ids: Sequence[str]) -> Mapping[str, float]:
    """Seconds by the committed ledger: the longest first, so that both processes end together."""
    known = _committed()
    return {
        key: max(known[key].seconds, LEAST_COST) if key in known else 5 * LEAST_COST for key in ids
    }
