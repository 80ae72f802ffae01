"""The cheap measures, in about a minute: what ``wmr-ctrl bench`` runs and prints.

All ratios come from interleaved rounds in three fresh processes. Above 1 the first of the two
named takes longer. A ratio that cannot be measured here has a line with the reason.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

from wmr_ctrl.core.paper import PAPER_TIMES

from . import floor, fmu, generated, numba_peer
from .hand_c import HandC
from .numpy_loop import closed_loop
from .setup import Case, Setup
from .timing import Builders, Candidate, Timing, built, measure_in_processes, reason

Progress = Callable[[float], None]

STEPS = 50_000
CONTROL = 1e-3


@dataclass(frozen=True)
class Ratio:
    """A named ratio of two candidates, with its target (at most, or at least)."""

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
    ``ratios`` by name (None where it could not be measured), ``reasons`` for each of these,
    ``spread`` (quartiles), ``targets``, ``ns`` (nanoseconds of each candidate's step, for the
    record) and ``paper`` (seconds for 10,000 evaluations: theirs and ours).
    """
    rounds = 9 if quick else 25
    found: dict[str, Timing] = {}
    failed: dict[str, str] = {}
    for place, group in enumerate(GROUPS):
        told = partial(_told, progress, place / len(GROUPS)) if progress else None
        try:
            found |= measure_in_processes(
                partial(built, group), next(iter(group)),
                rounds=rounds, progress=told, failed=failed,
            )  # fmt: skip
        except Exception as error:  # the process ended, say by a signal
            failed |= dict.fromkeys(group, reason(error))
    return summary(found, failed)


def summary(found: Mapping[str, Timing], failed: Mapping[str, str]) -> dict[str, Any]:
    """The result of `run_bench` from the timings of its candidates, and why others have none."""
    spread = {item.key: quartiles(found, item) for item in RATIOS}
    ours = {law: found[law].ns * 1e4 * 1e-9 for law in PAPER_TIMES if law in found}
    return {
        "ratios": {key: values and values[1] for key, values in spread.items()},
        "reasons": {
            item.key: failed.get(item.above) or failed.get(item.below, "")
            for item in RATIOS
            if not spread[item.key]
        },
        "spread": {key: values and [values[0], values[2]] for key, values in spread.items()},
        "targets": {item.key: item.target for item in RATIOS if item.target},
        "ns": {name: timing.ns for name, timing in found.items()},
        "paper": {"evaluations": 10_000, "matlab_s": PAPER_TIMES, "ours_s": ours},
    }


def table(result: Mapping[str, Any]) -> str:
    """The result as lines of text."""
    rows = [f"{'ratio':38} {'median':>9} {'quartiles':>19}  target"]
    for key, value in result["ratios"].items():
        if value:
            low, high = result["spread"][key]
            shown, last = f"{low:9.3g} {high:9.3g}", result["targets"].get(key, "")
            rows.append(f"{key:38} {value:9.3g} {shown}  {last}".rstrip())
        else:
            rows.append(f"{key:38} not measured: {result['reasons'][key]}")
    rows += ["", f"{'10,000 evaluations':38} {'paper, MATLAB':>14} {'here':>12}"]
    for law, seconds in result["paper"]["ours_s"].items():
        rows.append(f"{law:38} {PAPER_TIMES[law]:12.4f} s {1e3 * seconds:9.3f} ms")
    return "\n".join(rows)


@cache
def _setup(control: float | None = None) -> Setup:
    setup = Setup.from_scenario(generated.scenario())
    return setup if control is None else replace(setup, period=control)


@cache
def _hand(control: float | None = None) -> HandC:
    return HandC(_setup(control))


def _hand_step(name: str) -> Candidate:
    return floor.step_candidates(_hand(), STEPS)[f"{name}_step"]


def _numpy_step() -> Candidate:
    return floor.numpy_candidates(200)["nn_numpy"]


def _numba_step() -> Candidate:
    return numba_peer.step(_setup(), STEPS)


def _hand_loop(law: str) -> Candidate:
    return Candidate(partial(_hand(CONTROL).loop, law, CASE), CASE.samples)


def _numpy_loop() -> Candidate:
    short = replace(CASE, duration=0.2, t_change=0.1)
    return Candidate(partial(closed_loop, "nn", _setup(CONTROL), short), short.samples)


def _numba_loop() -> Candidate:
    return numba_peer.loop(_setup(CONTROL), CASE)


CASE = replace(Case(), control=CONTROL)
GROUPS: tuple[Builders, ...] = (
    {
        "nn_hand": partial(_hand_step, "nn"),
        "mb_hand": partial(_hand_step, "mb"),
        "plant_hand": partial(_hand_step, "plant"),
        **{law: partial(generated.step, law, STEPS) for law in PAPER_TIMES},
        "plant": partial(generated.plant_step, STEPS),
        "nn_numpy": _numpy_step,
        "nn_numba": _numba_step,
        "nn_vm": partial(generated.virtual_machine, "nn", 300),
        "nn_python": partial(generated.call_from_python, "nn", STEPS),
        "mb_python": partial(generated.call_from_python, "mb", STEPS),
    },
    {
        "nn_loop_hand": partial(_hand_loop, "nn"),
        "mb_loop_hand": partial(_hand_loop, "mb"),
        "nn_loop": partial(generated.closed_loop, "nn", CONTROL),
        "mb_loop": partial(generated.closed_loop, "mb", CONTROL),
        "nn_loop_numpy": _numpy_loop,
        "nn_loop_numba": _numba_loop,
        "nn_robot": partial(generated.robot, {}),
        "nn_robot_exact": partial(generated.robot, generated.EXACT),
        "nn_batch": partial(generated.batch, None, CONTROL),
        **{
            f"nn_batch_{name}": partial(generated.batch, name, CONTROL)
            for name in ("avx512", "avx2", "baseline")
        },
    },
    {"fmu_empty": partial(fmu.empty, 20_000), "fmu_plant": partial(fmu.plant, 20_000)},
)
"""What is measured together: steps of 10 ms; closed loops at 1 ms, a step of which is one control
sample with its plant steps; FMUs by FMPy.  The others of a group are divided by its first."""


def _told(progress: Progress, start: float, done: int, of: int) -> None:
    progress(start + done / of / len(GROUPS))


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
