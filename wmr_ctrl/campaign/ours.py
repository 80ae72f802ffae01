"""Beyond the paper: every law with and without the guard, one factor at a time around two bases.

Both bases are the paper's simulation with its noise cut at 3 standard deviations; one holds the
torque for 10 ms, the other for 100 ms.  The seeds were not used to choose anything.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

OUR_LAWS = ("pid", "smc", "mb", "nn", "prox")
HELD_OUT = (300, 301, 302)
"""Seeds that no gain and no bound was chosen with."""

BASES = MappingProxyType({"10 ms": 0.01, "100 ms": 0.1})
"""Control periods of the two base cases [s]."""

ADVERSARY = MappingProxyType(
    {
        "robot.m": 25.0,
        "robot.I": 2.7,
        "robot.mu": 0.0,
        "model.m": 50.0,
        "model.I": 5.4,
        "model.mu": 0.08,
        "changes": [],
        "disturbance.std": 0.0,
        "disturbance.push": [60.0, 15.0],
        "guard.M_min": [25.0, 2.7],
        "guard.M_max": [70.0, 7.5],
    }
)
"""Half the believed mass, no friction, and a push of dbar that always drives on."""

FAR = MappingProxyType({"initial.pose": [-5.0, -5.0, -0.7]})
DROP = ({"t": 3.0, "m": 25.0, "I": 2.7, "mu": 0.0},)

FACTORS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "base": {},
        "far start": FAR,
        "far start, friction believed 50 % too high": {**FAR, "model.mu": 0.12},
        "far start, mass and friction drop at 3 s": {**FAR, "changes": list(DROP)},
        "start outside": {"initial.velocity": [1.3, 2.0]},
        "adversary": ADVERSARY,
        "lemniscate": {"reference.kind": "lemniscate"},
        "stop and go": {"reference.kind": "stop-and-go"},
        "rounded square": {"reference.kind": "rounded-square"},
        "T = 1 ms": {"clock.control": 0.001},
        "T = 20 ms": {"clock.control": 0.02},
        "T = 50 ms": {"clock.control": 0.05},
        "tau_max = 20 N m": {"actuator.tau_max": 20.0},
        "tau_max = 10 N m": {"actuator.tau_max": 10.0},
        "tau_max = 6.5 N m": {"actuator.tau_max": 6.5},
        "tau_max = 5 N m": {"actuator.tau_max": 5.0},
    }
)
"""What one case changes against its base, by the case's name."""


@dataclass(frozen=True, slots=True)
class Case:
    """One run of the comparison: base and factor name the case, ``overrides`` make it."""

    base: str
    factor: str
    law: str
    guard: bool
    seed: int
    overrides: Mapping[str, Any] = field(hash=False)


def our_plan(
    laws: Sequence[str] = OUR_LAWS, seeds: Sequence[int] = HELD_OUT, bases: Sequence[str] = ()
) -> tuple[Case, ...]:
    """All cases; a factor that sets the period belongs to the first base only."""
    chosen = tuple(bases) or tuple(BASES)
    return tuple(
        Case(base, factor, law, guard, seed, overrides_of(base, factor))
        for base in chosen
        for factor, changed in FACTORS.items()
        if "clock.control" not in changed or base == next(iter(BASES))
        for law in laws
        for guard in (False, True)
        for seed in seeds[: 1 if factor == "adversary" else None]
    )


def overrides_of(base: str, factor: str) -> dict[str, Any]:
    """Fields of ``paper-simulation`` that a case changes."""
    common = {"clock.control": BASES[base], "disturbance.truncate": 3.0}
    return {**common, **FACTORS[factor]}
