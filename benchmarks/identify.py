"""Coverage of `wmr-ctrl identify`: how often 95 % intervals hold the truth, on two plants.

    python -m benchmarks.identify --logs 200
    python -m benchmarks.identify --logs 20 --case own:gust --case product:matched --json

``own`` is the plant of benchmarks/own_plant.py, which shares no code with the product, ``product``
the package's own runs.  Each case drives 40 s in closed loop.  Logs have the seeds 0 to N - 1.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from benchmarks.own_plant import Drives, Truth, log_of, simulate
from wmr_ctrl import simulate as simulate_product
from wmr_ctrl.errors import WmrError
from wmr_ctrl.identification import Identification, identify

NAMES = ("m", "I", "Fc", "Fv", "c", "Mv", "delay", "lag")
GUST = (3.0, 0.6, 0.5)
OWN: Mapping[str, tuple[Truth, Drives]] = {
    "matched": (Truth(), Drives()),
    "gust": (Truth(gust=GUST), Drives()),
    "sines": (Truth(), Drives("sines")),
    "backlash": (Truth(backlash=0.0175), Drives()),
    "stiction": (Truth(stiction=0.6), Drives()),
    "radius": (Truth(radius=0.01), Drives()),
    "creep": (Truth(creep=1500.0), Drives()),
    "circle": (Truth(), Drives("circle")),
}
"""Truth and drive of each case on the own plant; mass and inertia of "radius" are those of wheels
of the mean radius, delay of "creep" is shorter as the wheels show it."""
PRODUCT: Mapping[str, dict[str, object]] = {
    "matched": {},
    "gust": {"gust.size": [5.0, 1.0], "gust.time": 0.5},
}
ROBOT: dict[str, object] = {
    "reference.kind": "stop-and-go", "encoder.counts": 4096, "actuator.delay": 0.02,
    "actuator.lag": 0.03, "robot.mu": 0.05, "resistance.rolling": [0.01, 0.01],
    "resistance.viscous": [6.0, 0.5], "clock.duration": 40.0, "disturbance.std": 0.15,
}  # fmt: skip


def own_logs(case: str, count: int) -> Iterator[tuple[Identification | str, Mapping[str, float]]]:
    """Identifications of logs of the own plant, with the truth."""
    truth, drive = OWN[case]
    known = {"robot.r": truth.r, "robot.l": truth.l, "encoder.counts": truth.counts}
    for first in range(0, count, 50):
        several = min(50, count - first)
        columns = simulate(truth, several, 40.0, first, drive)
        for robot in range(several):
            yield tried(log_of(columns, robot), known), asdict(truth)


def product_logs(
    case: str, count: int
) -> Iterator[tuple[Identification | str, Mapping[str, float]]]:
    """The same of runs of the product."""
    values = {**ROBOT, **PRODUCT[case]}
    weight = 50.0 * 9.81
    truth = {"m": 50.0, "I": 5.4, "Fc": 0.05 * weight, "Fv": 6.0, "c": 0.01 * weight / 2, "Mv": 0.5,
             "delay": 0.02, "lag": 0.03}  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.npz"
        for seed in range(count):
            simulate_product(
                "paper-simulation-no-switch", "kanayama", seed=seed, overrides=values
            ).save(path)
            yield tried(path, {}), truth


def tried(log: Path | Mapping[str, list[float]], known: dict[str, object]) -> Identification | str:
    """The identification, or why there is none."""
    try:
        return identify(log, overrides=known)
    except WmrError as error:
        return str(error)


def covered(case: str, count: int) -> dict[str, object]:
    """How many of the logs' intervals hold the truth, by parameter, and what else happened."""
    plant, _, name = case.partition(":")
    logs = own_logs(name, count) if plant == "own" else product_logs(name, count)
    hits, halves = dict.fromkeys(NAMES, 0), {name: [] for name in NAMES}
    done = refused = moved = coloured = 0
    for found, truth in logs:
        if isinstance(found, str):
            refused += 1
            continue
        done += 1
        moved += any(" move" in text for text in found.remarks)
        coloured += len(found.fit.theta[found.fit.free]) > len(found.white.theta[found.white.free])
        for key in NAMES:
            item = found.parameters[key]
            hits[key] += item.low <= truth[key] <= item.high
            halves[key].append((item.high - item.low) / 2)
        if sys.stderr.isatty() or done % 50 == 0:
            print(f"{case}: {done} of {count}", file=sys.stderr)
    middle = {key: sorted(each)[len(each) // 2] if each else None for key, each in halves.items()}
    return {"case": case, "logs": done, "refused": refused, "coloured": coloured, "moved": moved,
            "covered": hits, "half_width": middle}  # fmt: skip


def table(rows: Sequence[Mapping[str, object]]) -> str:
    """The counts as Markdown."""
    head = ["case", "logs", *NAMES, "coloured", "moved", "refused"]
    lines = [head, ["---"] * len(head)]
    for row in rows:
        hits = [str(row["covered"][name]) for name in NAMES]  # type: ignore[index]
        lines.append([str(row["case"]), str(row["logs"]), *hits,
                      *(str(row[key]) for key in ("coloured", "moved", "refused"))])  # fmt: skip
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the cases and print how often each interval held the truth."""
    every = [f"own:{name}" for name in OWN] + [f"product:{name}" for name in PRODUCT]
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--logs", type=int, default=200, help="logs of each case")
    parser.add_argument("--case", action="append", choices=every, help="default: all")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(arguments)
    rows = [covered(case, given.logs) for case in given.case or every]
    print(json.dumps(rows, indent=2) if given.json else table(rows))


if __name__ == "__main__":
    main()
