"""A graphics processor against the processor beside it: ``python -m benchmarks.gpu bits | speed``.

``bits`` compares figures and columns of many runs of each law bit by bit, with the guard on and
off, on a robot with encoders and delay. ``speed``: a million runs, the same on all cores, and the
same graphs as a scan of JAX on the same device. Needs CuPy and a device; JAX if it is there.
"""

import hashlib
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from tempfile import TemporaryDirectory

import numpy as np

import wmr_ctrl
from wmr_ctrl.control.given import scenario_of
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.errors import ScenarioError
from wmr_ctrl.results import Monitor
from wmr_ctrl.simulation.batch import cores, run_logged, run_tasks
from wmr_ctrl.simulation.engines import runnable
from wmr_ctrl.simulation.memory import Task

RUNS = 1000
"""Number of runs of each law with the guard on, and off."""
ROBOT = "robot-10ms"
"""Encoders, dead reckoning, delay and lag, disturbances."""
MILLION = 1_000_000
PACE = 20_000
"""Number of runs for timing all cores."""


def hashed(array: np.ndarray) -> str:
    """Hash of an array's bits, with one kind of NaN."""
    if array.dtype.kind == "f":
        array = np.where(np.isnan(array), np.nan, array)
    return hashlib.blake2b(np.ascontiguousarray(array).tobytes(), digest_size=8).hexdigest()


def hashes(scenario: str, law: str, guard: bool, device: str, runs: int) -> tuple[str, str]:
    """Hash of all figures and of all columns of the first seeds."""
    loop = runnable(scenario_of(scenario, guard=guard), law, device=device)
    tasks = [Task(loop, seed) for seed in range(runs)]

    def columns(place: int, rows: np.ndarray, seen: Monitor) -> str:
        return hashed(rows) + repr(seen)

    figures = run_tasks(tasks)
    told = "".join(hashed(figures[name]) for name in sorted(figures))
    logged = "".join(run_logged(tasks, columns, jobs=1))
    return tuple(hashlib.sha256(text.encode()).hexdigest()[:16] for text in (told, logged))


def compared(case: tuple[str, str, bool, int]) -> tuple[str, bool, str]:
    """Name of a case, whether both devices agree, and the hashes or the refusal."""
    scenario, law, guard, runs = case
    words = f"{law}, guard {'on' if guard else 'off'}"
    try:
        first, second = (hashes(scenario, law, guard, device, runs) for device in ("cpu", "gpu"))
    except ScenarioError as error:
        return words, True, f"refused: {str(error)[:60]}"
    return words, first == second, f"figures {second[0]}, columns {second[1]}"


def bits(runs: int = RUNS) -> int:
    """Print for each case whether the devices agree; return the number of cases that differ."""
    cases = [(ROBOT, law, guard, runs) for law in LAWS for guard in (False, True)]
    wrong = 0
    with ProcessPoolExecutor(cores(), get_context("spawn")) as pool:
        for words, same, told in pool.map(compared, cases):
            wrong += not same
            print(f"{words:24} {'same bits' if same else 'DIFFERENT'}  {told}", flush=True)
    return wrong


def paced(scenario: str, law: str, device: str, runs: int) -> float:
    """Time [s] of ``runs`` runs with figures, after some that compile and load."""
    loop = runnable(scenario_of(scenario), law, device=device)
    run_tasks([Task(loop, seed) for seed in range(64)])
    tasks = [Task(loop, seed) for seed in range(runs)]
    start = time.perf_counter()
    run_tasks(tasks)
    return time.perf_counter() - start


def varied(runs: int) -> float:
    """Time [s] of ``runs`` runs of 2048 robots with different mass and friction."""
    base, rng = scenario_of("safe-simulation"), np.random.default_rng(0)
    loops = [
        runnable(scenario_of(base, {"robot.m": m, "robot.mu": mu}), "prox", device="gpu")
        for m, mu in rng.uniform((45.0, 0.06), (55.0, 0.1), (2048, 2))
    ]
    run_tasks([Task(loop, 0) for loop in loops])
    tasks = [Task(loops[k % 2048], k) for k in range(runs)]
    start = time.perf_counter()
    run_tasks(tasks)
    return time.perf_counter() - start


def speed(million: int = MILLION) -> Iterator[str]:
    """Lines of the table of times."""
    for law in ("prox", "nn"):
        scenario = "safe-simulation" if law == "prox" else "paper-simulation"
        gpu = paced(scenario, law, "gpu", million) * MILLION / million
        cpu = paced(scenario, law, "cpu", PACE) * MILLION / PACE
        yield f"{law}: a million runs of 80 s in {gpu:.1f} s, on {cores()} cores in {cpu:.0f} s"
    yield f"prox, 2048 robots: a million runs in {varied(million) * MILLION / million:.1f} s"
    with TemporaryDirectory() as folder:
        plan = {"scenario": "safe-simulation", "laws": ["prox"], "guard": [True], "seeds": million}
        plan["figures"] = ["violated", "position_rms"]
        start = time.perf_counter()
        made = wmr_ctrl.study(plan, folder, device="gpu")
        took = time.perf_counter() - start
        size = made.table.stat().st_size / 1e6
        yield f"study of {million} seeds, two figures: {took:.1f} s, table of {size:.0f} MB"
    yield from peers()


def peers() -> Iterator[str]:
    """Pace of JAX with these graphs as a scan, in one line per batch size."""
    try:
        from benchmarks.jax_loop import pace
    except ImportError:
        yield "JAX is not installed"
        return
    for batch in (2**14, 2**17):
        yield pace("safe-simulation", "prox", batch)


def main(words: Sequence[str]) -> int:
    """Run the named part; returns 1 if bits differ."""
    if "bits" in words:
        return int(bits() > 0)
    for line in speed():
        print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] or ["speed"]))
