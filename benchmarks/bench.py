"""The cheap measures, in about a minute: what ``wmr-ctrl bench`` runs and prints.

All ratios come from rounds that take turns in three fresh processes.  Above 1 the first of the two
named takes longer.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from wmr_ctrl.paper import PAPER_TIMES

from . import floor, fmu, generated, numba_peer
from .hand_c import HandC
from .numpy_loop import closed_loop
from .setup import Case, Setup
from .timing import Candidate, Timing, measure_in_processes

Progress = Callable[[float], None]

STEPS = 50_000
CONTROL = 1e-3


@dataclass(frozen=True)
class Ratio:
    """A named ratio of two candidates, with what it should be at most (or at least)."""

    key: str
    above: str
    below: str
    target: str


RATIOS = (
    Ratio("nn_step_vs_hand_c", "nn", "nn_hand", "<= 0.78"),
    Ratio("mb_step_vs_hand_c", "mb", "mb_hand", "<= 0.95"),
    Ratio("nn_step_numpy_vs_native", "nn_numpy", "nn", ">= 380"),
    Ratio("nn_step_vm_vs_native", "nn_vm", "nn", ">= 100"),
    Ratio("nn_step_numba_vs_native", "nn_numba", "nn", ""),
    Ratio("nn_call_from_python_vs_hand_c", "nn_python", "nn_hand", "<= 7"),
    Ratio("mb_call_from_python_vs_hand_c", "mb_python", "mb_hand", "<= 7"),
    Ratio("plant_step_vs_hand_c", "plant", "plant_hand", "<= 0.60"),
    Ratio("closed_loop_nn_vs_hand_c", "nn_loop", "nn_loop_hand", "<= 0.80"),
    Ratio("closed_loop_mb_vs_hand_c", "mb_loop", "mb_loop_hand", "<= 0.80"),
    Ratio("closed_loop_numpy_vs_native", "nn_loop_numpy", "nn_loop", ""),
    Ratio("closed_loop_numba_vs_native", "nn_loop_numba", "nn_loop", ""),
    Ratio("closed_loop_nn_sensors_vs_exact", "nn_robot", "nn_robot_exact", "<= 1.3"),
    Ratio("batch_nn_per_core_vs_scalar_hand_c", "nn_loop_hand", "nn_batch", ">= 4 (AVX-512)"),
    Ratio("batch_nn_avx512_vs_scalar_hand_c", "nn_loop_hand", "nn_batch_avx512", ">= 4"),
    Ratio("batch_nn_avx2_vs_scalar_hand_c", "nn_loop_hand", "nn_batch_avx2", ">= 2.6"),
    Ratio("batch_nn_baseline_vs_scalar_hand_c", "nn_loop_hand", "nn_batch_baseline", ""),
    Ratio("fmu_plant_step_vs_empty_call", "fmu_plant", "fmu_empty", ""),
)


def run_bench(progress: Progress | None = None, quick: bool = True) -> dict[str, Any]:
    """Measure everything in this module.

    Parameters
    ----------
    progress
        Called with the share done, 0 to 1.
    quick
        Nine rounds in each of three processes; else 25.

    Returns
    -------
    ``ratios`` by name (None where it could not be measured), ``spread`` (their quartiles),
    ``targets``, ``ns`` (nanoseconds of each candidate's step, for the record) and ``paper``
    (seconds for 10,000 evaluations: theirs and ours).  Raises CompilerError without a compiler.
    """
    rounds = 9 if quick else 25
    found: dict[str, Timing] = {}
    for place, (factory, base) in enumerate(FACTORIES):
        told = partial(_told, progress, place / len(FACTORIES)) if progress else None
        found |= measure_in_processes(factory, base, rounds=rounds, progress=told)
    return summary(found)


def summary(found: Mapping[str, Timing]) -> dict[str, Any]:
    """The result of `run_bench` from the timings of its candidates."""
    spread = {item.key: quartiles(found, item) for item in RATIOS}
    ours = {law: found[law].ns * 1e4 * 1e-9 for law in PAPER_TIMES if law in found}
    return {
        "ratios": {key: values and values[1] for key, values in spread.items()},
        "spread": {key: values and [values[0], values[2]] for key, values in spread.items()},
        "targets": {item.key: item.target for item in RATIOS if item.target},
        "ns": {name: timing.ns for name, timing in found.items()},
        "paper": {"evaluations": 10_000, "matlab_s": PAPER_TIMES, "ours_s": ours},
    }


def table(result: Mapping[str, Any]) -> str:
    """The result as lines of text."""
    rows = [f"{'ratio':38} {'median':>9} {'quartiles':>19}  target"]
    for key, value in result["ratios"].items():
        low, high = result["spread"][key] or (None, None)
        shown = f"{value:9.3g} {low:9.3g} {high:9.3g}" if value else f"{'not measured':>29}"
        rows.append(f"{key:38} {shown}  {result['targets'].get(key, '')}".rstrip())
    rows += ["", f"{'10,000 evaluations':38} {'paper, MATLAB':>14} {'here':>12}"]
    for law, seconds in result["paper"]["ours_s"].items():
        rows.append(f"{law:38} {PAPER_TIMES[law]:12.4f} s {1e3 * seconds:9.3f} ms")
    return "\n".join(rows)


def steps() -> dict[str, Candidate]:
    """Control and plant steps: hand-written, generated, NumPy, numba, CasADi's VM, from Python."""
    setup = Setup.from_scenario(generated.scenario())
    hand = floor.step_candidates(HandC(setup), STEPS)
    slow = floor.numpy_candidates(200)
    return {
        **{f"{name.removesuffix('_step')}_hand": item for name, item in hand.items()},
        **{law: generated.step(law, STEPS) for law in PAPER_TIMES},
        "plant": generated.plant_step(STEPS),
        "nn_numpy": slow["nn_numpy"],
        **numba_peer.step_candidates(setup, STEPS),
        "nn_vm": generated.virtual_machine("nn", 300),
        **{f"{law}_python": generated.call_from_python(law, STEPS) for law in ("mb", "nn")},
    }


def loops() -> dict[str, Candidate]:
    """Closed loops at 1 ms; a step is one control sample with its plant step."""
    setup = replace(Setup.from_scenario(generated.scenario()), period=CONTROL)
    hand, case = HandC(setup), replace(Case(), control=CONTROL)
    short = replace(case, duration=0.2, t_change=0.1)
    return {
        **{
            f"{law}_loop_hand": Candidate(partial(hand.loop, law, case), case.samples)
            for law in ("mb", "nn")
        },
        **{f"{law}_loop": generated.closed_loop(law, CONTROL) for law in ("mb", "nn")},
        "nn_loop_numpy": Candidate(partial(closed_loop, "nn", setup, short), short.samples),
        **numba_peer.loop_candidates(setup, case),
        "nn_robot": generated.robot({}),
        "nn_robot_exact": generated.robot(generated.EXACT),
        **generated.batches(CONTROL),
    }


def fmus() -> dict[str, Candidate]:
    """Steps of the plant FMU and of an empty one, by FMPy."""
    return fmu.candidates(20_000)


FACTORIES: tuple[tuple[Callable[[], dict[str, Candidate]], str], ...] = (
    (steps, "nn_hand"),
    (loops, "nn_loop_hand"),
    (fmus, "fmu_empty"),
)
"""What is measured together, and the candidate that the others are divided by."""


def _told(progress: Progress, start: float, done: int, of: int) -> None:
    progress(start + done / of / len(FACTORIES))


def quartiles(found: Mapping[str, Timing], item: Ratio) -> tuple[float, float, float] | None:
    """Quartiles and median of a ratio, low to high, round by round; None if not measured."""
    if item.above not in found or item.below not in found:
        return None
    pairs = zip(found[item.above].ratios, found[item.below].ratios, strict=True)
    values = sorted(above / below for above, below in pairs)
    quarter = len(values) // 4
    return values[quarter], values[len(values) // 2], values[-1 - quarter]


if __name__ == "__main__":
    print(table(run_bench()))
