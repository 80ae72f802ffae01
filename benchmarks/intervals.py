"""Coverage of `wmr-ctrl identify`: how often 95 % intervals hold the truth, on two plants.

    python -m benchmarks.intervals --logs 200
    python -m benchmarks.intervals --logs 20 --case own:gust --case base:pi --json

``own`` is the plant of benchmarks/own_plant.py, which shares no code with the product, ``product``
the package's own runs, both in closed loop; ``body`` its rigid body on tyres (extra `physics`);
``base`` are bases that take velocities, of benchmarks/own_base.py.  Each log has 40 s, and the
seeds are 0 to N - 1.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from benchmarks.own_base import Base
from benchmarks.own_base import simulate as simulate_base
from benchmarks.own_plant import Drives, Truth, log_of, simulate
from wmr_ctrl import load_scenario
from wmr_ctrl import simulate as simulate_product
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.identification import BaseIdentification, Identification, identify

Found = BaseIdentification | str

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
    "all": (Truth(gust=(2.0, 0.4, 0.5), backlash=0.005, stiction=0.2, radius=0.005, creep=4000.0),
            Drives()),
    "circle": (Truth(), Drives("circle")),
}  # fmt: skip
"""Truth and drive of each case on the own plant; mass and inertia of "radius" are those of wheels
of the mean radius, delay of "creep" is shorter as the wheels show it."""
BASES: Mapping[str, Base] = {
    "first-order": Base(),
    "counts": Base(counts=2048),
    "few-counts": Base(counts=256),
    "slow-push": Base(push_time=0.5),
    "no-push": Base(push=(0.0, 0.0), counts=2048),
    "ramp": Base(accel=(0.8, 2.0)),
    "pi": Base(loop="pi"),
    "second-order": Base(loop="second-order"),
}
"""Bases that take velocities."""
PRODUCT: Mapping[str, dict[str, object]] = {
    "matched": {},
    "gust": {"gust.size": [5.0, 1.0], "gust.time": 0.5},
    "radius": {"wheels.radius": [0.01, -0.01]},
    "slope": {"slope.angle": 0.01},
}
ROBOT: dict[str, object] = {
    "reference.kind": "stop-and-go", "encoder.counts": 4096, "actuator.delay": 0.02,
    "actuator.lag": 0.03, "robot.mu": 0.05, "resistance.rolling": [0.01, 0.01],
    "resistance.viscous": [6.0, 0.5], "clock.duration": 40.0, "disturbance.std": 0.15,
}  # fmt: skip


def own_logs(case: str, count: int) -> Iterator[tuple[Found, Mapping[str, float]]]:
    """Identifications of logs of the own plant, with the truth."""
    truth, drive = OWN[case]
    known = {"robot.r": truth.r, "robot.l": truth.l, "encoder.counts": truth.counts}
    for first in range(0, count, 50):
        several = min(50, count - first)
        columns = simulate(truth, several, 40.0, first, drive)
        for robot in range(several):
            yield tried(log_of(columns, robot), known), {n: asdict(truth)[n] for n in NAMES}


def base_logs(case: str, count: int) -> Iterator[tuple[Found, Mapping[str, float]]]:
    """Identifications of logs of bases that take velocities, with the truth."""
    base = BASES[case]
    names = {"first-order": ("gain", "tau"), "pi": ("wn", "zeta"),
             "second-order": ("gain", "wn", "zeta")}[base.loop]  # fmt: skip
    names += ("accel",) if min(base.accel) < math.inf else ()
    truth = {f"{name}{axis + 1}": getattr(base, name)[axis] for name in names for axis in (0, 1)}
    truth |= {"delay1": base.delay, "delay2": base.delay}
    known: dict[str, object] = {"robot.r": base.r, "robot.l": base.l}
    known |= {"encoder.counts": base.counts} if base.counts else {}
    for first in range(0, count, 50):
        for log in simulate_base(base, min(50, count - first), 40.0, first):
            yield tried(log, known, "velocity"), truth


def product_logs(
    case: str, count: int, body: bool = False
) -> Iterator[tuple[Found, Mapping[str, float]]]:
    """Identifications of the product's runs, on the plane or as a rigid body, with the truth.

    Wheels that turn count twice: with their inertia about the axle, too.
    """
    values, weight = {**ROBOT, **PRODUCT[case]}, 50.0 * 9.81
    truth = {"m": 50.0, "I": 5.4, "Fc": 0.05 * weight, "Fv": 6.0, "c": 0.01 * weight / 2, "Mv": 0.5,
             "delay": 0.02, "lag": 0.03}  # fmt: skip
    if body:
        scenario = load_scenario("paper-simulation-no-switch")
        wheels = scenario.body.wheel_mass
        truth = {"m": 50.0 + wheels, "I": 5.4 + wheels * scenario.robot.l**2}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.npz"
        for seed in range(count):
            simulate_product(
                "paper-simulation-no-switch", "kanayama", seed=seed, overrides=values,
                plant="mujoco" if body else "ode",
            ).save(path)  # fmt: skip
            yield tried(path, {}), truth


def tried(
    log: Path | Mapping[str, list[float]], known: dict[str, object], base: str = "torque"
) -> Found:
    """Identification of a log, or the reason why there is none."""
    try:
        return identify(log, overrides=known, base=base)
    except WmrError as error:
        return str(error)


def covered(case: str, count: int) -> dict[str, object]:
    """Number of the logs' intervals that hold the truth, by parameter, and other outcomes."""
    plant, _, name = case.partition(":")
    if plant in ("product", "body"):
        logs = product_logs(name, count, plant == "body")
    else:
        logs = own_logs(name, count) if plant == "own" else base_logs(name, count)
    hits: Counter[str] = Counter()
    halves: dict[str, list[float]] = {}
    happened: Counter[str] = Counter()
    for found, truth in logs:
        if isinstance(found, str):
            happened["refused"] += 1
            continue
        happened["logs"] += 1
        if isinstance(found, Identification):
            happened["coloured"] += bool(found.fit.free.sum() > found.white.free.sum())
            happened["refuted"] += bool(found.bounds.refuted)
        for key, value in truth.items():
            item = found.parameters.get(key)
            halves.setdefault(key, [])
            if item is not None:
                hits[key] += item.low <= value <= item.high
                halves[key].append((item.high - item.low) / 2)
        if sys.stderr.isatty() or happened["logs"] % 50 == 0:
            print(f"{case}: {happened['logs']} of {count}", file=sys.stderr)
    middle = {key: sorted(each)[len(each) // 2] if each else None for key, each in halves.items()}
    told = {key: happened[key] for key in ("logs", "refused", "coloured", "refuted")}
    return {"case": case, **told, "covered": {key: hits[key] for key in halves},
            "half_width": middle}  # fmt: skip


def table(rows: Sequence[Mapping[str, object]]) -> str:
    """Counts as Markdown; the parameters of a wrongly chosen loop count as missed."""
    last = ("coloured", "refuted", "refused")
    lines = [["case", "logs", "intervals that hold the truth", *last], ["---"] * 6]
    for row in rows:
        hits = row["covered"]
        assert isinstance(hits, dict)
        held = ", ".join(f"{name} {count}" for name, count in hits.items())
        lines.append([str(row["case"]), str(row["logs"]), held, *(str(row[key]) for key in last)])
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the cases and print how often each interval held the truth."""
    every = [f"own:{name}" for name in OWN] + [f"product:{name}" for name in PRODUCT]
    every += ["body:matched", *(f"base:{name}" for name in BASES)]
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
