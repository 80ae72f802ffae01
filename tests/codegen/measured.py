"""Measure the packages' footprints and write the committed copies.

``python -m tests.codegen.measured`` measures with the GNU Arm compiler, writes
wmr_ctrl/codegen/templates/footprint.json, and renews fmu/golden/c; without that compiler it only
renews the copies.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from dataclasses import asdict
from pathlib import Path

import casadi as ca

from wmr_ctrl.codegen import footprint
from wmr_ctrl.codegen.package import write_package
from wmr_ctrl.codegen.resources import fmu_dir
from wmr_ctrl.scenario import load_scenario

COMPILER = "arm-none-eabi-gcc"
TARGET = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
LAWS = ("mb", "nn", "pid", "smc")
GOLDEN = fmu_dir() / "golden" / "c"
COPIES = tuple((law, float32) for law in ("mb", "nn") for float32 in (False, True))
VERSION = "casadi-version.txt"


def measure(law: str, float32: bool, folder: Path) -> footprint.Footprint:
    """Footprint of a law's package."""
    write_package(law, folder, load_scenario("paper-simulation"), float32=float32)
    command = [COMPILER, "-std=c99", "-O2", "-ffp-contract=off", *TARGET, "-fstack-usage", "-c",
               f"wmr_{law}.c"]  # fmt: skip
    subprocess.run(command, cwd=folder, check=True)
    text, data, bss, *_ = _output(["arm-none-eabi-size", f"wmr_{law}.o"], folder)[1].split()
    frames = (folder / f"wmr_{law}.su").read_text(encoding="utf-8").splitlines()
    stack = sum(int(line.split("\t")[1]) for line in frames if "defaults" not in line)
    version = _output([COMPILER, "-dumpversion"], folder)[0]
    return footprint.Footprint(int(text), int(data) + int(bss), stack, f"gcc {version}")


def _output(command: list[str], folder: Path) -> list[str]:
    done = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    return done.stdout.splitlines()


def write_golden() -> None:
    """Renew the committed packages."""
    for law, float32 in COPIES:
        folder = GOLDEN / footprint.key(law, float32)
        shutil.rmtree(folder, ignore_errors=True)
        write_package(law, folder, load_scenario("paper-simulation"), float32=float32)
    (GOLDEN / VERSION).write_text(f"{ca.__version__}\n", encoding="utf-8")


def main() -> None:
    """Measure, record, renew."""
    if shutil.which(COMPILER):
        found = {}
        for law in LAWS:
            for float32 in (False, True):
                with tempfile.TemporaryDirectory() as folder:
                    measured = measure(law, float32, Path(folder))
                found[footprint.key(law, float32)] = asdict(measured)
        footprint.RECORD.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    footprint._record.cache_clear()
    write_golden()


if __name__ == "__main__":
    main()
