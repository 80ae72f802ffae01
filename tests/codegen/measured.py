"""Measure the packages' footprints and write the committed copies.

``python -m tests.codegen.measured`` measures with the GNU Arm compiler and on an emulated board,
writes wmr_ctrl/codegen/templates/footprint.json, and renews fmu/golden/c; without those tools it
only renews the copies.
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from dataclasses import asdict, astuple, dataclass
from pathlib import Path

import casadi as ca

from tests.board.emulated import BOARDS, COMPILER, missing
from tests.board.lockstep import lockstep
from tests.codegen.packages import write_package
from tests.commands import finished
from tests.tables import changes
from wmr_ctrl.codegen.package import (
    FILTER,
    RECORD,
    Footprint,
    footprint_key,
    packaged,
    step_kernel,
)  # fmt: skip
from wmr_ctrl.codegen.resources import fmu_dir
from wmr_ctrl.control.filter.filter import called_filter
from wmr_ctrl.control.laws.registry import NAMES
from wmr_ctrl.control.setup import settle
from wmr_ctrl.world.scenario import load_scenario

BOARD = "cortex-m4f"
TARGET = ("-mthumb", "-mfloat-abi=hard", *BOARDS[BOARD].flags)
PACKAGES = tuple(
    (law, float32, guarded)
    for law in NAMES for float32 in (False, True) for guarded in (False, True)
)  # fmt: skip
SCENARIOS = {False: "paper-simulation", True: "safe-simulation"}
"""Scenario with and without a guard."""
ROBOTS = ("robot-10ms", "robot-100ms")
"""Guarded scenarios with encoders and late drives, whose packages are compiled only."""
GOVERNED = """
filter = {kind = "governor", tau = [0.2, 0.3], gain = [0.9, 1.1], d = [0.05, 0.05]}
filter.odometry = [0.02, 0.02]
clock.control = 0.05
"""
SLOW = """
filter.loop = "second-order"
filter.damping = [0.5, 1.0]
filter.frequency = [2.9, 3.6]
clock.control = 0.05
"""
FILTERS = {
    "clip": changes('filter.kind = "clip"'),
    "governor": changes(GOVERNED),
    "governor, delay of 0 to 30 ms": changes(f"{GOVERNED}filter.delay = [0.0, 0.03]"),
    "band of 50 commands": changes(f'{SLOW}filter.kind = "band"'),
    "clip of slow commands": changes(f'{SLOW}filter.kind = "clip"; filter.slew = [0.1, 0.2]'),
}
"""Command filters whose packages are compiled only."""
NOMINAL = "paper-simulation-nominal"
GOLDEN = fmu_dir() / "golden" / "c"
COPIES = tuple((law, float32) for law in ("mb", "nn") for float32 in (False, True))
VERSION = "casadi-version.txt"


@dataclass(frozen=True)
class Sizes:
    """Figures from the compiler: operations of the kernel, then bytes."""

    operations: int
    code: int
    data: int
    stack: int


def sizes(law, float32, preset, folder, stated=()):
    """Sizes of a law's package, or of the command filter's, compiled for the board's processor."""
    scenario = load_scenario(preset, dict(stated))
    write_package(law, folder, scenario, float32=float32)
    command = [COMPILER, "-std=c99", "-O2", "-ffp-contract=off", *TARGET, "-fstack-usage", "-c",
               f"wmr_{law}.c"]  # fmt: skip
    finished(command, cwd=folder)
    text, data, bss, *_ = _output(["arm-none-eabi-size", f"wmr_{law}.o"], folder)[1].split()
    frames = (folder / f"wmr_{law}.su").read_text(encoding="utf-8").splitlines()
    stack = sum(int(line.split("\t")[1]) for line in frames if "defaults" not in line)
    system = called_filter(scenario) if law == FILTER else packaged(settle(scenario, law))
    return Sizes(step_kernel(system).operations, int(text), int(data) + int(bss), stack)


def loop_scenario(guarded):
    """Scenario of the boards: the paper's circle without noise or change."""
    return load_scenario(NOMINAL, {"guard.enabled": guarded})


def footprint(law, float32, preset, folder, stated=(), board=(None, None, None)):
    """Footprint of a package: of a board that has run it, deepest stack and instructions."""
    found = sizes(law, float32, preset, folder, stated)
    return Footprint(
        *astuple(found), *board, f"gcc {_output([COMPILER, '-dumpversion'], folder)[0]}"
    )


def _output(command, folder):
    return finished(command, cwd=folder).stdout.splitlines()


def write_golden():
    """Renew the committed packages."""
    for law, float32 in COPIES:
        folder = GOLDEN / footprint_key(law, float32)
        shutil.rmtree(folder, ignore_errors=True)
        write_package(law, folder, load_scenario("paper-simulation"), float32=float32)
    (GOLDEN / VERSION).write_text(f"{ca.__version__}\n", encoding="utf-8")


def write_footprints():
    """Measure and record all packages."""
    found = {}
    for law, float32, guarded in PACKAGES:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            loop = lockstep(law, loop_scenario(guarded), BOARD, folder / "loop", float32=float32)
            board = (loop.stack, loop.instructions, loop.most_instructions)
            each = [footprint(law, float32, SCENARIOS[guarded], folder / "sizes", board=board)]
            for preset in ROBOTS if guarded else ():
                each.append(footprint(law, float32, preset, folder / preset))
        by_form = {item.operations: asdict(item) for item in each}
        found[footprint_key(law, float32, guarded)] = list(by_form.values())
    for float32 in (False, True):
        with tempfile.TemporaryDirectory() as place:
            each = [
                footprint(FILTER, float32, SCENARIOS[False], Path(place) / str(k), stated)
                for k, stated in enumerate(FILTERS.values())
            ]
        found[footprint_key(FILTER, float32)] = [asdict(item) for item in each]
    RECORD.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def main():
    """Measure, record, renew."""
    if missing():
        print(missing(), file=sys.stderr)
    else:
        write_footprints()
    write_golden()


if __name__ == "__main__":
    main()
