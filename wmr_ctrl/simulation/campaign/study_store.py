"""The folder of a study: plan, provenance, chunks written atomically, and the table.

study.json      the plan, its identity, what made the results
chunks/*.npz    rows of finished chunks: index, outcome, refusal, figures
columns.csv     name, unit and meaning of the table's columns
table.csv       one row a run, in the order of the index; empty where a figure is not finite
"""

import heapq
import json
import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from filelock import FileLock, Timeout
from numpy.typing import NDArray

from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.core.fields.section import Section, quantities
from wmr_ctrl.results import FIGURES, atomic_text
from wmr_ctrl.results.files import atomic_write, write_csv

from .plan import Study

Rows = Mapping[str, NDArray[np.generic]]
"""``index``, ``outcome``, ``refusal`` and an array a figure, one row a run."""
HEAD = ("index", "law", "guard", "seed")
REFUSAL = "refusal"
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")
"""A number within the words of a refusal; the one in ``v_u1`` is none."""
FORMAT = "wmr_ctrl study, version 1"


class StudyFolder:
    """Folder of a study's results; made by `opened`."""

    def __init__(self, folder: Path, plan: Study) -> None:
        self.folder, self.plan = folder, plan
        self.chunks = folder / "chunks"
        self.members = {"index", "outcome", REFUSAL, *plan.figures}

    def chunk_path(self, look: int, indices: Sequence[int]) -> Path:
        """File of the rows of some runs; the name identifies them."""
        return self.chunks / f"{look:02d}-{indices[0]:012d}-{indices[-1]:012d}-{len(indices)}.npz"

    def rows(self, path: Path) -> Rows | None:
        """Rows of a finished chunk; None if it is missing or damaged."""
        try:
            with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
                rows = {name: archive[name] for name in archive.files}
        except Exception:
            return None
        return rows if rows.keys() == self.members else None

    def keep(self, path: Path, rows: Rows) -> None:
        """Write the rows of a chunk atomically.  Raises ResultFileError."""
        with atomic_write(path) as file:
            np.savez(file, **rows)  # type: ignore[arg-type]

    def refusals(self, looks: Sequence[Sequence[Path]]) -> dict[str, int]:
        """Number of runs that a guard refused for each reason."""
        chunks = (self.rows(path) for paths in looks for path in paths)
        return counted_reasons(text for rows in chunks if rows for text in rows[REFUSAL].tolist())

    def write_table(self, looks: Sequence[Sequence[Path]]) -> Path:
        """Write table.csv and columns.csv from the chunks of each look.  Raises ResultFileError."""
        target = self.folder / "table.csv"
        described = described_columns(self.plan)
        write_csv(self.folder / "columns.csv", ("name", "unit", "meaning"), described)
        streams = [self._cells(paths) for paths in looks]
        header = (*HEAD, *self.plan.keys, "outcome", *self.plan.figures, REFUSAL)
        write_csv(target, header, heapq.merge(*streams))
        return target

    def _cells(self, paths: Sequence[Path]) -> Iterator[tuple[object, ...]]:
        """The table's row of each run in some chunks, beginning with its index."""
        plan = self.plan
        for path in paths:
            rows = self.rows(path)
            if rows is None:
                raise ResultFileError(
                    f"{str(path)!r} has been deleted or damaged. Run the study again: it makes "
                    "only what is missing."
                )
            columns = [rows[name].tolist() for name in plan.figures]
            texts = (rows[name].tolist() for name in ("index", "outcome", REFUSAL))
            last, labels, values = -1, ("", ""), [""]
            for index, outcome, refusal, *figures in zip(*texts, *columns, strict=True):
                cell, place = divmod(index, plan.seeds)
                if cell != last:
                    last, case = cell, plan.case(cell)
                    labels = case.law, str(case.guard).lower()
                    given = plan.values(cell)
                    values = [v if isinstance(v, str) else json.dumps(v) for v in given]
                numbers = [x if math.isfinite(x) else None for x in figures]
                seed = plan.first_seed + place
                yield (index, *labels, seed, *values, outcome, *numbers, refusal)


def counted_reasons(refusals: Iterable[str]) -> dict[str, int]:
    """Counts of each reason among texts, the most frequent first; empty texts are skipped.

    Reasons that differ only in numbers are one, with the numbers of the first.
    """
    counts, first = Counter[str](), dict[str, str]()
    for text in filter(None, refusals):
        words = NUMBER.sub("", text)
        first.setdefault(words, text)
        counts[words] += 1
    return {first[words]: count for words, count in counts.most_common()}


def described_columns(plan: Study) -> Iterator[tuple[str, str, str]]:
    """Name, unit and meaning of each column of the table."""
    yield from (
        ("index", "1", "number of the run in the plan"),
        ("law", "", "control law"),
        ("guard", "", "whether the velocity guard is on"),
        ("seed", "1", "seed of all noise"),
    )
    for key in plan.keys:
        unit, meaning = _field(plan, key)
        yield key, unit, meaning
    yield "outcome", "", "how the run ended; refused: a guard that cannot keep its limits"
    for name in plan.figures:
        yield name, FIGURES[name].unit, FIGURES[name].meaning
    yield REFUSAL, "", "why the guard refused the run, else empty"


def _field(plan: Study, key: str) -> tuple[str, str]:
    """Unit and meaning of a field of the scenario; empty for a gain."""
    table, _, name = key.partition(".")
    if table in ("gains", "changes"):
        return "", "field of the scenario"
    section: Section = plan.loaded.table(table)
    what = dict(quantities(type(section))).get(name.partition("[")[0])
    return ("", "field of the scenario") if what is None else (what.unit, what.doc)


@contextmanager
def opened(folder: Path, plan: Study, facts: Mapping[str, str]) -> Iterator[StudyFolder]:
    """Context of a study's folder, new or continued, for one process at a time.

    Raises ResultFileError for a folder of another plan or version, one in use by another process,
    or one that cannot be written.
    """
    try:
        (folder / "chunks").mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / ".lock").acquire(timeout=0)  # ends with its process in any case
    except Timeout:
        raise ResultFileError(
            f"{str(folder)!r}: another process is working on this study. Wait until it ends, or "
            "name another folder."
        ) from None
    except OSError as error:
        raise ResultFileError(f"cannot write {str(folder)!r}: {error.strerror}.") from error
    with lock:
        _same_study(folder, plan, facts)
        for scratch in (folder / "chunks").glob(".*.npz"):
            scratch.unlink(missing_ok=True)  # of a process that was killed
        yield StudyFolder(folder, plan)


def _same_study(folder: Path, plan: Study, facts: Mapping[str, str]) -> None:
    file = folder / "study.json"
    try:
        begun = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        begun = None
    except (OSError, ValueError) as error:
        raise ResultFileError(f"{str(file)!r} cannot be read: {error}.") from error
    wanted = {"format": FORMAT, "identity": plan.identity, "provenance": dict(facts)}
    if begun is None:
        text = json.dumps({**wanted, "runs": plan.runs, "plan": plan.described()}, indent=1)
        with atomic_text(file) as stream:
            stream.write(text + "\n")
        return
    if begun.get("identity") != plan.identity:
        raise ResultFileError(
            f"{str(folder)!r} holds the results of another plan. Name another folder for this one, "
            "or give the plan that the folder was started with (study.json)."
        )
    before = begun.get("provenance", {})
    differ = [key for key in facts if before.get(key) != facts[key]]
    if differ:
        listed = ", ".join(f"{key} {before.get(key)} then, {facts[key]} now" for key in differ)
        raise ResultFileError(
            f"{str(folder)!r} was started with other code ({listed}), whose results may differ. "
            "Name another folder, or continue with that version."
        )


@contextmanager
def finished_study(folder: Path) -> Iterator[None]:
    """Context for reading a study's files; raises ResultFileError if none is finished."""
    try:
        yield
    except ResultFileError:
        raise
    except (OSError, KeyError, ValueError, StopIteration) as error:
        file = error.filename if isinstance(error, OSError) else None
        why = f"{Path(file).name} cannot be read" if file else "its files are damaged"
        raise ResultFileError(
            f"{str(folder)!r} holds no finished study: {why}. Name the folder that `wmr-ctrl "
            "study PLAN.toml --out DIR` wrote, once the study has run to its end."
        ) from error
