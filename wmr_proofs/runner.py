"""``wmr-ctrl prove``: all claims in two processes, longest first, with progress.

The results are compared with the committed ledger.
"""

import gc
import os
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from fnmatch import fnmatchcase
from functools import lru_cache
from importlib.resources import files
from multiprocessing import get_context
from pathlib import Path

from wmr_ctrl.core.errors import UnknownNameError, install
from wmr_ctrl.results import atomic_text, write_all
from wmr_ctrl.results.ledger import COMMITTED, PROVED, Entry, Ledger, load
from wmr_ctrl.simulation.batch import deaf_to_interrupts

from .claim import Claim
from .comparison import differences, exit_code, stale

PROCESSES = 2
AT_ONCE = 2.0
"""Seconds of cost that are over before another process has begun."""
LEAST_COST = 0.1
"""Seconds that an entry is taken to cost at least; what is new is taken to cost five of these."""
Progress = Callable[[float, Entry], None]


def prove(
    only: Iterable[str] = (),
    progress: Progress | None = None,
    processes: int = PROCESSES,
    examine: bool = False,
) -> Ledger:
    """Check the claims that ``only`` names (all by default): ids, their beginnings, or globs.

    ``progress(share, entry)`` is called after each, with the share of the whole cost that is done.
    ``examine``: functions are altered again, which takes hours for all entries. UnknownNameError if
    a name in ``only`` matches no entry.
    """
    ids = selected(tuple(only))
    checked = {entry.id: entry for entry in _run(ids, progress, processes, examine)}
    return Ledger(tuple(checked[key] for key in ids))


def selected(only: Sequence[str]) -> list[str]:
    """Ids of the requested claims, in the ledger's order."""
    from .claims import all_claims

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


def check_id(key: str, examine: bool = False) -> Entry:
    """Check one entry, in any process."""
    from .claims import all_claims
    from .entry import check

    claim = next(claim for claim in all_claims() if claim.id == key)
    entry = check(claim, _committed().get(key))
    if not examine or entry.verdict != PROVED:
        return entry
    from .noticed import tried

    return replace(entry, altered=tried(claim, tuple(entry.altered), {}))


@lru_cache(maxsize=1)
def _committed() -> dict[str, Entry]:
    return load().by_id() if COMMITTED.exists() else {}


def hashes(ids: Iterable[str] | None = None) -> dict[str, str]:
    """Hash of each claim's graph at present (of the named ones, or all)."""
    from .claims import all_claims
    from .entry import graph_hash

    asked = None if ids is None else set(ids)
    claims = (claim for claim in all_claims() if asked is None or claim.id in asked)
    return {claim.id: graph_hash(claim) for claim in claims}


def stale_entries() -> list[str]:
    """Ids whose graph has changed since the ledger was committed."""
    return stale(hashes(), load())


def _matches(key: str, asked: str) -> bool:
    if set("*?[") & set(asked):
        return fnmatchcase(key, asked)
    return key == asked or key.startswith(asked + ".")


def _run(
    ids: Sequence[str], progress: Progress | None, processes: int, examine: bool
) -> list[Entry]:
    checked: list[Entry] = []
    costs, done = _costs(ids), 0.0
    for entry in _entries(sorted(ids, key=lambda key: -costs[key]), processes, examine):
        checked.append(entry)
        done += costs[entry.id]
        if progress:
            progress(done / sum(costs.values()), entry)
    return checked


def _entries(ids: Sequence[str], processes: int, examine: bool) -> Iterable[Entry]:
    if processes < 2 or len(ids) < 2:
        yield from (check_id(key, examine) for key in ids)
        return
    context = get_context("spawn")
    with ProcessPoolExecutor(processes, context, _begin, (os.getpid(),)) as pool:
        with deaf_to_interrupts():
            jobs = [pool.submit(_checked, key, examine) for key in ids]
        for future in as_completed(jobs):
            yield future.result()


def _begin(parent: int) -> None:
    """Set up a worker process: it ends with its parent, and its solvers use one thread only.

    Ctrl-C ends it silently, but only after this set-up.  Garbage is collected between two entries:
    a collection in the thread that watches the parent would free a solver's terms while the solver
    uses them.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if os.name != "nt":
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    gc.disable()
    follow_parent(parent)


def _checked(key: str, examine: bool) -> Entry:
    entry = check_id(key, examine)
    gc.collect()
    gc.freeze()  # modules and graphs stay: the next collection need not walk them
    return entry


def follow_parent(parent: int) -> None:
    """End this process when ``parent`` is gone for any reason, since a solver would continue."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _costs(ids: Sequence[str]) -> Mapping[str, float]:
    """Seconds from the committed ledger: longest first, so that both processes end together."""
    known, new = _committed(), 5 * LEAST_COST
    return {key: max(known[key].seconds, LEAST_COST) if key in known else new for key in ids}


REMEDY = "Some entries were not checked; install the proving packages with: " + install("proofs")
ALTERED = {"tried": "functions altered", "caught": "REFUTED then", "open": "left open"}


def run_prove(
    only: Iterable[str] = (),
    json_file: Path | None = None,
    progress: Progress | None = None,
    examine: bool = False,
) -> int:
    """Check, print a summary, write ``json_file``; the exit code of `ledger.exit_code`.

    ``examine``: functions are altered again.
    """
    asked = tuple(only)
    cost = sum(_costs(selected(asked)).values())
    ledger = prove(asked, progress, 1 if cost <= AT_ONCE else PROCESSES, examine)
    committed = load() if COMMITTED.exists() else Ledger(())
    if json_file is not None:
        with atomic_text(json_file) as stream:
            stream.write(ledger.to_json() + "\n")
    if asked:
        sys.stdout.write("\n".join(map(described, ledger.entries)) + "\n")
    sys.stdout.write("\n".join(summary(ledger, committed, not asked, examine)) + "\n")
    return exit_code(ledger, committed, complete=not asked)


def run_export(folder: Path, only: Iterable[str] = ()) -> None:
    """Write the obligations of the z3 entries that ``only`` names, and print their number.

    SMT-LIB 2 files with the expected answers, for other solvers.  Raises ResultFileError if a file
    cannot be written.
    """
    from .certificates import obligations_of

    readme = files("wmr_proofs").joinpath("obligations.md").read_text(encoding="utf-8")
    write_all({"README.md": readme}, folder)
    count = 0
    for claim, entry in _recorded(only):
        texts = {f"{o.name}.smt2": o.file(claim.id) for o in obligations_of(claim, entry)}
        count += len(write_all(texts, folder / claim.id)) if texts else 0
    sys.stdout.write(f"{count} obligations in {folder}; its README.md says how to check them.\n")


def run_certificates(folder: Path, only: Iterable[str] = ()) -> int:
    """Write index and certificates of the obligations that ``only`` names; prove nothing.

    Returns 1 if an obligation of the index differs from that of the present graphs, else 0.
    """
    from .certificates import FOLDER, differing, index

    run_export(folder, only)
    for path in FOLDER.iterdir():
        shutil.copyfile(path, folder / path.name)
    known = index()
    others = {claim.id: names for claim, entry in _recorded(only)
              if claim.id in known and (names := differing(claim, entry))}  # fmt: skip
    for key, names in others.items():
        sys.stdout.write(f"{key}: other obligations than in the index: {', '.join(names)}\n")
    sys.stdout.write("python -I -S wmr_proofs/check.py FOLDER checks the certificates.\n")
    return 1 if others else 0


def _recorded(only: Iterable[str]) -> Iterable[tuple[Claim, Entry]]:
    """The claims that ``only`` names, with their committed entries."""
    from .claims import all_claims

    wanted = set(selected(tuple(only)))
    known = _committed()
    return [(c, known[c.id]) for c in all_claims() if c.id in wanted and c.id in known]


def described(entry: Entry) -> str:
    """An entry with all its data, as text."""
    point = ", ".join(f"{name} = {value}" for name, value in (entry.counterexample or {}).items())
    rows = {
        "claim": entry.claim,
        "hypotheses": entry.hypotheses,
        "method": entry.method,
        "rests on": ", ".join(entry.premises),
        "counterexample": point,
        "functions": ", ".join(entry.functions),
        "not noticed": ", ".join(name for name, said in entry.altered.items() if said == PROVED),
        "not tried": ", ".join(name for name, said in entry.altered.items() if not said),
        "altered": ", ".join(f"{n} {ALTERED[key]}" for key, n in (entry.alterations or {}).items()),
        "confirmed by": ", ".join(entry.confirmed_by),
        "certificate": "of each obligation" * bool(entry.certificate),
        "cancelled by CasADi": f"{entry.cancelled} operations, all defined" * bool(entry.cancelled),
        "versions": ", ".join(f"{name} {number}" for name, number in entry.versions.items()),
    }
    lines = [f"{entry.id}: {entry.verdict}"]
    return "\n".join([*lines, *(f"  {name}: {text}" for name, text in rows.items() if text), ""])


def provenance(ledger: Ledger, committed: Ledger, examine: bool) -> str:
    """Numbers of entries checked now, given, and taken from the committed ledger, as text."""
    known = {entry.id: entry for entry in committed.entries if entry.cancelled is not None}
    checked = [entry for entry in ledger.entries if entry.graph_hash]
    given = sum(1 for e in ledger.entries if not e.graph_hash and e.verdict != "NOT_CHECKED")
    altered = 0 if examine else sum(1 for entry in checked if entry.alterations)
    confirmed = sum(1 for entry in checked if entry.confirmed_by)
    certified = sum(1 for entry in checked if entry.certificate)
    then = ((known[e.id], e) for e in checked if e.id in known)
    defined = sum(1 for old, e in then if old.is_about(e.graph_hash, e.versions))
    taken = (
        f"the alterations of {altered} of them, the second solvers' answers for {confirmed} and "
        f"that what CasADi cancels is defined for {defined}, where claim, method and versions are "
        "the same"
    )
    return (
        f"{len(checked)} checked now, their functions searched anew; {given} given (by hand, "
        f"definitions, open). {certified} have certificates. From the record: {taken}. Claims are "
        "about real numbers, except where an entry's id or method speaks of rounding."
    )


def summary(ledger: Ledger, committed: Ledger, complete: bool, examine: bool) -> list[str]:
    """Counts and their source, differences from the committed ledger, and missing extras."""
    counts = ", ".join(f"{count} {verdict}" for verdict, count in ledger.tally().items())
    lines = [counts, provenance(ledger, committed, examine)]
    others = differences(ledger, committed, complete)
    lines += [f"{d.id}: {d.now}, committed {d.committed}" for d in others]
    if any(entry.verdict == "NOT_CHECKED" for entry in ledger.entries):
        lines.append(REMEDY)
    return lines
