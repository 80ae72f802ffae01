"""Run a study: chunk after chunk by an executor, look after look, until the table is complete."""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import TypeAlias

import numpy as np

from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.core.errors import ArgumentError, WmrError
from wmr_ctrl.core.fields.arguments import checks_arguments
from wmr_ctrl.core.fields.files import one_command
from wmr_ctrl.simulation.batch import Progress, check_jobs
from wmr_ctrl.version import __version__
from wmr_ctrl.world.scenario import Scenario

from .engine import build_loop
from .plan import PlannedCase, Study
from .study_chunks import (
    THREADS,
    StudyChunk,
    chunk_rows,
    executor_named,
)
from .study_plan import load_plan, plan_of
from .study_store import Rows, StudyFolder, opened

IN_FLIGHT = 3
"""Chunks that wait at an executor for each that runs."""
GPU_CHUNK = 2**17
"""Least runs between two writes with a graphics processor: fewer would not fill it."""
MakeRows: TypeAlias = Callable[[StudyChunk, int | None], dict[str, np.ndarray]]
"""Outcome and figures of a chunk's runs on so many threads; what executors run."""


@dataclass(frozen=True)
class StudyOutcome:
    """Results of a study: its folder, the table's path, the numbers of runs made and planned.

    ``stopped``: cases that the rule ended before all their seeds; ``refused``: number of runs that
    a guard refused, by reason (`counted_reasons`).
    """

    folder: Path
    table: Path
    runs: int
    planned: int
    stopped: int
    refused: Mapping[str, int]

    @property
    def all_refused(self) -> bool:
        """True if no run was made because the guard refused each."""
        return sum(self.refused.values()) == self.runs > 0

    def __str__(self) -> str:
        early = f"; {self.stopped} cases were settled early" if self.stopped else ""
        head = f"{self.runs} of {self.planned} planned runs{early}; the table: {self.table}"
        why = [f"{count} refused: {reason}" for reason, count in self.refused.items()]
        return "\n".join((head, *why))


@checks_arguments
@one_command()
def study(
    plan: str | Path | Mapping[str, object] | Study,
    out: str | Path,
    *,
    executor: str | Executor = "threads",
    jobs: int | None = None,
    progress: Progress | None = None,
    device: str = "cpu",
) -> StudyOutcome:
    """Run a plan (a TOML file, its tables, or a Study) and write ``out``/table.csv.

    ``executor``: "threads" of this process, "dask" for processes of this machine, a Dask scheduler
    as "dask://HOST:PORT", or any `concurrent.futures` executor; ``jobs``: threads or processes;
    ``device``: "gpu" for the graphics processor of the process that makes the runs (CUDA: extra
    gpu). The table has the same bytes for all of them. After an interruption, the same call makes
    only the runs that are missing. Runs of the plant "mujoco" (extra physics) are made by processes
    instead of threads. Raises ArgumentError, UnknownNameError, ScenarioError, ResultFileError,
    MissingExtraError or CompilerError; finished runs are kept.
    """
    from wmr_ctrl.simulation.engines import check_device

    check_jobs(jobs)
    if isinstance(plan, str | Path):
        plan = load_plan(plan)
    chosen = plan_of(plan) if isinstance(plan, Mapping) else plan
    check_device(device, chosen.plant, here=executor == THREADS)
    own = [law for law in chosen.laws if law in LAWS.given]
    if own and isinstance(executor, str) and executor != THREADS:
        raise ArgumentError(
            f"the workers of {executor} do not know the law {own[0]!r}, which is in a file or an "
            "object of this process. Install it as a package with an entry point, or use the "
            "executor threads."
        )
    if chosen.plant == "mujoco":
        from wmr_ctrl.simulation.physics.rigid import description, mujoco

        mujoco()
        description(chosen.loaded)  # refuses what no rigid body is
    facts = partial(study_facts, chosen.loaded, chosen.laws, chosen.plant, device)
    if executor == THREADS:  # in this thread, where Ctrl-C ends a compiler
        return run_study(chosen, Path(out), chunk_rows, facts(), None, jobs, progress, device)
    with ThreadPoolExecutor(1) as beside:
        known = beside.submit(facts)  # while processes start
        with executor_named(executor, jobs, known.result, facts) as running:
            made_by = known.result()
            where = (running, jobs, progress, device)
            return run_study(chosen, Path(out), chunk_rows, made_by, *where)


def study_facts(
    scenario: Scenario, laws: tuple[str, ...], plant: str, device: str = "cpu"
) -> dict[str, str]:
    """Facts that determine a result besides the plan: the version, and the code of the plan's laws.

    The laws' loops without guard are compiled for it, here or on the queried worker, so that each
    kind of machine compiles before its first chunk.
    """
    cases = (PlannedCase(scenario, law, False, plant=plant) for law in laws)
    digests = [build_loop(case, device).compiled.digest for case in cases]
    code = hashlib.sha256(" ".join(digests).encode()).hexdigest()[:16]
    facts = {"version": __version__, "kernels": code}
    if plant == "mujoco":
        from wmr_ctrl.simulation.physics.rigid import mujoco

        facts["mujoco"] = str(mujoco().__version__)
    return facts


def run_study(
    plan: Study,
    out: Path,
    make: MakeRows,
    facts: Mapping[str, str],
    executor: Executor | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
    device: str = "cpu",
) -> StudyOutcome:
    """Make the runs of ``plan`` that the folder ``out`` lacks, and write the table.

    ``executor`` None: in this process on ``jobs`` threads; else ``make`` is sent to it, one thread
    per chunk. The table's bytes depend on neither, nor on interruptions. Raises ResultFileError,
    and the errors of a run; finished chunks stay.
    """
    with opened(out, plan, facts) as folder:
        rule = plan.stop
        counts = [plan.seeds] if rule is None else rule.looks(plan.seeds)
        cells: Sequence[int] = range(plan.cells)
        values: dict[int, list[float]] = {}
        looks: list[list[Path]] = []
        done, begin = 0, 0

        def advance(count: int) -> None:
            nonlocal done
            done += count
            if progress:
                progress(done / plan.runs)

        for look, end in enumerate(counts):
            chosen = (cell * plan.seeds + k for cell in cells for k in range(begin, end))
            runs = len(cells) * (end - begin)
            longest = max(plan.chunk, GPU_CHUNK) if device == "gpu" else plan.chunk
            blocks = _blocks(chosen, runs, longest)
            chunk = partial(_chunk, plan, device)
            paths = _finished(folder, look, blocks, chunk, make, executor, jobs, advance)
            looks.append(paths)
            begin = end
            if rule is not None and end < plan.seeds:
                _collect(folder, paths, rule.figure, values)
                enough = {c for c in cells if rule.reached(np.array(values[c]), len(counts), c)}
                cells = [cell for cell in cells if cell not in enough]
                if not cells:
                    break
        table, refused = folder.write_table(looks), folder.refusals(looks)
        stopped = plan.cells - len(cells)
        return StudyOutcome(out, table, done, plan.runs, stopped, refused)


def _collect(
    folder: StudyFolder, paths: Sequence[Path], figure: str, values: dict[int, list[float]]
) -> None:
    """Add a look's figures to each case's, in the order of the seeds."""
    for path in paths:
        rows = folder.rows(path)
        assert rows is not None, "written or read just now"
        numbers = rows[figure].tolist()
        for index, value in zip(rows["index"].tolist(), numbers, strict=True):
            values.setdefault(index // folder.plan.seeds, []).append(value)


def _finished(
    folder: StudyFolder,
    look: int,
    blocks: Iterator[list[int]],
    chunk: Callable[[list[int]], StudyChunk],
    make: MakeRows,
    executor: Executor | None,
    jobs: int | None,
    advance: Callable[[int], None],
) -> list[Path]:
    """Paths of a look's chunks, in order; missing chunks are computed."""
    paths = []

    def missing() -> Iterator[tuple[Path, list[int]]]:
        for block in blocks:
            path = folder.chunk_path(look, block)
            paths.append(path)
            rows = folder.rows(path)
            if rows is not None and rows["index"].tolist() == block:
                advance(len(block))
            else:
                yield path, block

    def keep(path: Path, block: list[int], columns: Rows) -> None:
        folder.keep(path, {"index": np.array(block, dtype=np.int64), **columns})
        advance(len(block))

    if executor is None:
        for path, block in missing():
            keep(path, block, make(chunk(block), jobs))
    else:
        _sent(missing(), chunk, make, executor, jobs, keep)
    return paths


def _chunk(plan: Study, device: str, block: Sequence[int]) -> StudyChunk:
    """The runs with some indices; runs of one cell share their case."""
    cases = {cell: plan.case(cell) for cell in dict.fromkeys(k // plan.seeds for k in block)}
    runs = ((cases[k // plan.seeds], plan.first_seed + k % plan.seeds) for k in block)
    return StudyChunk(tuple(runs), plan.figures, device=device)


def _sent(
    missing: Iterator[tuple[Path, list[int]]],
    chunk: Callable[[list[int]], StudyChunk],
    make: MakeRows,
    executor: Executor,
    jobs: int | None,
    keep: Callable[[Path, list[int], Rows], None],
) -> None:
    """Send chunks to an executor, slightly ahead of the running ones, and store the results."""
    ahead = IN_FLIGHT * (jobs or 4)
    waiting: dict[Future[Rows | WmrError], tuple[Path, list[int]]] = {}
    try:
        for path, block in chain(missing, [(None, [])]):
            while waiting and (path is None or len(waiting) >= ahead):
                ended, _ = wait(waiting, return_when=FIRST_COMPLETED)
                for future in ended:
                    answer = future.result()
                    if isinstance(answer, WmrError):
                        raise answer
                    keep(*waiting.pop(future), answer)
            if path is not None:
                waiting[executor.submit(_told, make, chunk(block), 1)] = (path, block)
    finally:
        for future in waiting:
            future.cancel()


def _told(make: MakeRows, chunk: StudyChunk, jobs: int | None) -> Rows | WmrError:
    """The rows of a chunk, or a user's error as a value.

    Dask would print an exception raised in a worker there, with its traceback.
    """
    try:
        return make(chunk, jobs)
    except WmrError as error:
        return error.with_traceback(None)


def _blocks(indices: Iterator[int], count: int, longest: int) -> Iterator[list[int]]:
    """Split ``count`` indices into the fewest lists of at most ``longest``, of nearly equal length.

    A short last chunk would leave all workers but one idle.
    """
    lists = -(-count // longest)
    for k in range(lists):
        yield list(islice(indices, count * (k + 1) // lists - count * k // lists))
