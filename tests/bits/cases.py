"""Cases that run on every platform: a law, its numbers, and the bits of its result."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

from tests.tables import changes
from wmr_ctrl.codegen.build import build_loop, program_of
from wmr_ctrl.control.setup import Setup, settle
from wmr_ctrl.core.compiled import CompiledLoop
from wmr_ctrl.core.signals import elements
from wmr_ctrl.results.windows import windows_of
from wmr_ctrl.simulation.engines import runnable_of
from wmr_ctrl.simulation.memory import Task, laid_out, noise_key
from wmr_ctrl.world.scenario import load_scenario

SEED = 5
WIDEST = 8
"""Robots of the widest vector."""
EFFECTS = changes("""
    disturbance = {std = 1.0, truncate = 2.0, push = [3.0, 0.5]}
    sensor.pose_period = 0.05
    sensor.pose_noise = 0.004
    sensor.velocity_noise = [0.002, 0.004]
    sensor.correction = 0.6
    actuator = {lag = 0.02, delay = 0.003}
""")
GUARD = changes("""
    guard.enabled = true
    guard.alpha = 5.0
    initial.velocity = [0.99, -1.45]
""")
"""Settings with which the guard acts on every law."""
CASES = {
    "plain": {}, "guarded": GUARD, "effects": EFFECTS, "everything": {**EFFECTS, **GUARD},
}  # fmt: skip
"""Changes of paper-simulation: 80 s with noise, and other masses from 40 s on."""


@dataclass(frozen=True)
class Case:
    """A law's loop in the form of one of CASES, compiled for one robot."""

    name: str
    setup: Setup
    compiled: CompiledLoop

    @property
    def program(self):
        """Its C text."""
        return program_of(self.setup)

    @property
    def loop(self):
        """Ready to run."""
        return runnable_of(self.compiled, self.setup)

    @property
    def windows(self):
        """Windows of the sums."""
        return list(windows_of(self.loop.settings).values())

    def bits(self):
        """The output of case.c, from our library: rows, findings, state; findings, state, sums."""
        task = Task(self.loop, SEED)
        logged, watched = laid_out([task], [], log=True), laid_out([task], self.windows)
        logged.run()
        watched.run()
        shown = (logged.logged(0).tobytes(), left(logged), left(watched))
        return b"".join((*shown, watched.sums.tobytes()))


@functools.cache
def case(law, name):
    """Case of that name in CASES."""
    setup = settle(load_scenario("paper-simulation", CASES[name]), law)
    return Case(name, setup, build_loop(setup, watched=True))


@functools.cache
def bits_of(law, name):
    """Bits of a law's case, computed once."""
    return case(law, name).bits()


def left(memory):
    """Findings and state of the first lane."""
    return memory.findings[:, 0].tobytes() + memory.state[:, 0].tobytes()


def numbers(one):
    """numbers.h of a case."""
    compiled, clock, delay = one.compiled, one.setup.scenario.clock, one.setup.scenario.actuator
    keys = ", ".join(f"{{{a}u, {b}u}}" for a, b in (noise_key(SEED + k) for k in range(WIDEST)))
    return "\n".join((
        f"#define WMR_SET {one.name}",
        "#include <math.h>",
        "#include <stdint.h>",
        f"#define SAMPLES {clock.samples}",
        f"#define PHASES {len(compiled.phase_start)}",
        f"#define WINDOWS {len(one.windows)}",
        f"#define DELAY {round(delay.delay / clock.plant)}",
        f"static const uint64_t KEYS[][2] = {{{keys}}};",
        f"static const int64_t PHASE_START[] = {{{listed(compiled.phase_start)}}};",
        f"static const int64_t WINDOW[] = {{{listed([n for w in one.windows for n in w])}}};",
        f"static const double START[] = {{{listed(compiled.start)}}};",
        f"static const double PARAMETERS[] = {{{listed(sum(compiled.parameters, ()))}}};",
        "",
    ))  # fmt: skip


def listed(values):
    """Numbers as C literals with exact bits."""
    return ", ".join(map(_spelled, values))


def _spelled(value):
    if isinstance(value, int):
        return str(value)
    return value.hex() if math.isfinite(value) else "-INFINITY" if value < 0 else "INFINITY"


def different(law, name, shown):
    """First difference of ``shown`` from a case's bits, as text; empty if they are equal."""
    wanted, columns = bits_of(law, name), elements(case(law, name).compiled.layout.columns)
    if shown == wanted:
        return ""
    if len(shown) != len(wanted):
        return f"{law}, {name}: {len(shown)} bytes for {len(wanted)}"
    first = next(k for k in range(len(wanted)) if shown[k] != wanted[k]) // 8
    return f"{law}, {name}: row {first // len(columns)} {columns[first % len(columns)]}"
