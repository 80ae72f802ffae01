"""Measure the packages' footprints and write the committed copies.

``python -m tests.codegen.measured`` measures with the GNU Arm compiler and on an emulated board,
writes wmr_ctrl/codegen/templates/footprint.json, and renews fmu/golden/c; without those tools it
only renews the copies.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from dataclasses import asdict, astuple, dataclass
from pathlib import Path
from types import MappingProxyType

import casadi as ca

from tests.board.emulated import BOARDS, COMPILER, missing
from tests.board.lockstep import lockstep
from tests.codegen.packages import write_package
from wmr_ctrl.codegen.package import (
    FILTER,
    RECORD,
    Footprint,
    footprint_key,
    packaged,
    step_kernel,
)
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
"""By whether the guard is on."""
ROBOTS = ("robot-10ms", "robot-100ms")
"""Guarded scenarios with encoders and late drives, whose packages are compiled only."""
GOVERNED = {
    "filter.kind": "governor", "filter.tau": (0.2, 0.3), "filter.gain": (0.9, 1.1),
    "filter.d": (0.05, 0.05), "filter.odometry": (0.02, 0.02), "clock.control": 0.05,
}  # fmt: skip
FILTERS = {
    "clip": {"filter.kind": "clip"},
    "governor": GOVERNED,
    "governor, delay of 0 to 30 ms": {**GOVERNED, "filter.delay": (0.0, 0.03)},
    "band of 50 commands": {
        "filter.kind": "band", "filter.loop": "second-order", "filter.damping": (0.5, 1.0),
        "filter.frequency": (2.9, 3.6), "clock.control": 0.05,
    },
    "clip of slow commands": {
        "filter.kind": "clip", "filter.loop": "second-order", "filter.damping": (0.5, 1.0),
        "filter.frequency": (2.9, 3.6), "filter.slew": (0.1, 0.2), "clock.control": 0.05,
    },
}  # fmt: skip
"""Command filters whose packages are compiled only."""
NOTHING = MappingProxyType({})
NOMINAL = "paper-simulation-nominal"
GOLDEN = fmu_dir() / "golden" / "c"
COPIES = tuple((law, float32) for law in ("mb", "nn") for float32 in (False, True))
VERSION = "casadi-version.txt"


@dataclass(frozen=True)
class Sizes:
    """What the compiler tells: operations of the kernel, then bytes."""

    operations: int
    code: int
    data: int
    stack: int


def sizes(law, float32, preset, folder, changes=NOTHING):
    """Sizes of a law's package, or of the command filter's, compiled for the board's processor."""
    scenario = load_scenario(preset, changes)
    write_package(law, folder, scenario, float32=float32)
    command = [COMPILER, "-std=c99", "-O2", "-ffp-contract=off", *TARGET, "-fstack-usage", "-c",
               f"wmr_{law}.c"]  # fmt: skip
    subprocess.run(command, cwd=folder, check=True)
    text, data, bss, *_ = _output(["arm-none-eabi-size", f"wmr_{law}.o"], folder)[1].split()
    frames = (folder / f"wmr_{law}.su").read_text(encoding="utf-8").splitlines()
    stack = sum(int(line.split("\t")[1]) for line in frames if "defaults" not in line)
    system = called_filter(scenario) if law == FILTER else packaged(settle(scenario, law))
    return Sizes(step_kernel(system).operations, int(text), int(data) + int(bss), stack)


def loop_scenario(guarded):
    """What the boards run: the paper's circle without noise or change."""
    return load_scenario(NOMINAL, {"guard.enabled": guarded})


def measure(law, float32, guarded, folder):
    """Footprint of a law's package."""
    found = sizes(law, float32, SCENARIOS[guarded], folder / "sizes")
    loop = lockstep(law, loop_scenario(guarded), BOARD, folder / "loop", float32=float32)
    board = (loop.stack, loop.instructions, loop.most_instructions)
    return Footprint(*astuple(found), *board, _version(folder))


def compiled(law, float32, preset, folder, changes=NOTHING):
    """Footprint of a package that no board has run."""
    found = sizes(law, float32, preset, folder, changes)
    return Footprint(*astuple(found), None, None, None, _version(folder))


def _version(folder):
    return f"gcc {_output([COMPILER, '-dumpversion'], folder)[0]}"


def _output(command, folder):
    done = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    return done.stdout.splitlines()


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
        with tempfile.TemporaryDirectory() as folder:
            each = [measure(law, float32, guarded, Path(folder))]
            each += [
                compiled(law, float32, preset, Path(folder) / preset)
                for preset in (ROBOTS if guarded else ())
            ]
        by_form = {item.operations: asdict(item) for item in each}
        found[footprint_key(law, float32, guarded)] = list(by_form.values())
    for float32 in (False, True):
        with tempfile.TemporaryDirectory() as folder:
            each = [
                compiled(FILTER, float32, SCENARIOS[False], Path(folder) / str(k), changes)
                for k, changes in enumerate(FILTERS.values())
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
