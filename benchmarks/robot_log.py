"""Write the log of the identification page, and further drives of its robot.

    python -m benchmarks.robot_log OUT.csv [--drive DRIVE.csv | --circle] [--seed N]

The robot is that of `benchmarks/own_plant.py` with its own numbers; the model of `identify` has no
gusts, no wheels of different size and no creeping tyres. DRIVE.csv has columns t, v, omega.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np

from .own_plant import Drives, Truth, log_of, simulate

TRUTH = Truth(
    m=24.6, I=1.13, Fc=9.0, Fv=5.0, c=2.0, Mv=0.2, delay=0.03, lag=0.04, r=0.0625, l=0.17,
    gust=(2.0, 0.4, 0.5), radius=0.002, creep=6000.0,
)  # fmt: skip
SEED, SECONDS, STEP = 0, 60.0, 1e-3


def drive_of(path: str) -> Drives:
    """A drive from a CSV file with the columns t [s], v [m/s] and omega [rad/s], each held."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    names = {name.split(" ")[0]: name for name in rows[0]}
    t, v, omega = (
        np.array([float(row[names[key]]) for row in rows]) for key in ("t", "v", "omega")
    )
    when = np.arange(round((t[-1] - t[0]) / TRUTH.period) + 1) * TRUTH.period
    row = np.clip(np.searchsorted(t - t[0], when + 1e-9, "right") - 1, 0, len(t) - 1)
    return Drives("given", wanted=np.column_stack((v[row], omega[row])))


def columns_of(drive: Drives | None, seed: int) -> dict[str, list[float]]:
    """A log as ``identify`` takes it."""
    seconds = SECONDS
    if drive is not None and drive.wanted is not None:
        seconds = len(drive.wanted) * TRUTH.period
    return log_of(simulate(TRUTH, 1, seconds, seed, drive, STEP), 0)


def write(path: str, columns: dict[str, list[float]]) -> None:
    """Write one line per sample, with six digits."""
    with Path(path).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(
            [f"{value:.6g}" for value in row] for row in zip(*columns.values(), strict=True)
        )


def main() -> None:
    """Write a log."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out")
    parser.add_argument("--drive")
    parser.add_argument("--circle", action="store_true")
    parser.add_argument("--seed", type=int, default=SEED)
    given = parser.parse_args()
    drive = drive_of(given.drive) if given.drive else Drives("circle") if given.circle else None
    write(given.out, columns_of(drive, given.seed))


if __name__ == "__main__":
    main()
