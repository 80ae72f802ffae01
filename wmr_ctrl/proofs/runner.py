"""All claims on two processes, longest first, with progress."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context

from wmr_ctrl.errors import UnknownNameError
from wmr_ctrl.proofs.ledger import COMMITTED, Entry, Ledger, load

PROCESSES = 2
Progress = Callable[[int, int, Entry], None]


def prove(
    only: Iterable[str] = (), progress: Progress | None = None, processes: int = PROCESSES
) -> Ledger:
    """Check the claims whose id is, or begins with, one of ``only`` (all by default).

    ``progress(done, total, entry)`` is called after each.  UnknownNameError for an unknown id.
    """
    ids = selected(tuple(only))
    found = {entry.id: entry for entry in _run(ids, progress, processes)}
    return Ledger(tuple(found[key] for key in ids))


def selected(only: Sequence[str]) -> list[str]:
    """Ids of the claims that are asked for, in the ledger's order."""
    from wmr_ctrl.proofs.claims import all_claims

    known = [claim.id for claim in all_claims()]
    for asked in only:
        if not any(_matches(key, asked) for key in known):
            raise UnknownNameError(
                "entry", asked, known, "An entry's beginning up to a dot selects all of its kind."
            )
    return [key for key in known if not only or any(_matches(key, asked) for asked in only)]


def check_id(key: str) -> Entry:
    """One entry, in whatever process."""
    from wmr_ctrl.proofs.check import check
    from wmr_ctrl.proofs.claims import all_claims

    return check(next(claim for claim in all_claims() if claim.id == key))


def hashes() -> dict[str, str]:
    """Hash of each claim's graph as the product is now."""
    from wmr_ctrl.proofs.check import graph_hash
    from wmr_ctrl.proofs.claims import all_claims

    return {claim.id: graph_hash(claim) for claim in all_claims()}


def _matches(key: str, asked: str) -> bool:
    return key == asked or key.startswith(asked + ".")


def _run(ids: Sequence[str], progress: Progress | None, processes: int) -> list[Entry]:
    found: list[Entry] = []
    for entry in _entries(_longest_first(ids), processes):
        found.append(entry)
        if progress:
            progress(len(found), len(ids), entry)
    return found


def _entries(ids: Sequence[str], processes: int) -> Iterable[Entry]:
    if processes < 2 or len(ids) < 2:
        yield from map(check_id, ids)
        return
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        for future in as_completed([pool.submit(check_id, key) for key in ids]):
            yield future.result()


def _longest_first(ids: Sequence[str]) -> list[str]:
    """By the seconds of the committed ledger, so that both processes finish together."""
    known = load().by_id() if COMMITTED.exists() else {}
    return sorted(ids, key=lambda key: -known[key].seconds if key in known else 0.0)
