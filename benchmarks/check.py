"""CPU seconds of `wmr-ctrl check`: ``python -m benchmarks.check [PRESET ...] [--law LAW,...]``.

The table has a row for each preset, a column for each law and one for all laws at once; corridors
are left out. Each call is a process of its own, with a mass or limits that no call had before, so
that only compiled code is reused. The time includes all threads and compilers; the first call of a
preset, which compiles, is not reported.
"""

from __future__ import annotations

import argparse
import os
import random
import subprocess
import sys

from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.world.scenario import Scenario, load_scenario, preset_names

ALL = "all"


def unseen(scenario: Scenario, share: float) -> tuple[str, ...]:
    """Override that no call had before: the mass or both limits, larger by ``share``."""
    if random.random() < 0.5:
        return "--set", f"robot.m={scenario.robot.m * (1 + share)!r}"
    linear, angular = (limit * (1 + share) for limit in scenario.limits.v_u1)
    return "--set", f"limits.v_u1={linear!r},{angular!r}"


def cpu_seconds(preset: str, laws: str) -> float:
    """CPU time [s] of a process that checks these laws, and of its own processes."""
    chosen = ["--law", laws, *(["--json"] if laws == ALL else ["--only", "run"])]
    own = unseen(load_scenario(preset), 1e-3 * random.random())
    command = [sys.executable, "-m", "wmr_ctrl", "check", preset, *own, *chosen]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    assert process.stderr is not None
    said = process.stderr.read().decode()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{' '.join(command)}: {said}")
    return used.ru_utime + used.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("presets", nargs="*", metavar="PRESET")
    parser.add_argument("--law", default=",".join((*LAWS, ALL)), help="laws, or all at once")
    told = parser.parse_args()
    laws = told.law.split(",")
    print(f"{'CPU s':34}", *(f"{law:>8}" for law in laws))
    for preset in told.presets or preset_names():
        cpu_seconds(preset, ALL)
        print(f"{preset:34}", *(f"{cpu_seconds(preset, law):8.2f}" for law in laws), flush=True)


if __name__ == "__main__":
    main()
