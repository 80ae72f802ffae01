"""Kinds of bases and drives, half of them with faults; nothing of wmr_ctrl is imported."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from benchmarks.own_axes import NONE, Axis, Drive, Truth

Drawn = tuple[Truth, Drive]
SEEDS, LATER_SEEDS = 100, 5000
"""First seed of a kind, and of every third one."""


def first(r: np.random.Generator, loop: str = "first-order") -> Drawn:
    """Base that a scenario can describe, with random numbers."""
    low, high = (0.06, 0.3) if loop == "first-order" else (5.0, 13.0)
    gains = (1.0, 1.0) if loop == "pi" else r.uniform(0.7, 1.2, 2)
    axes = [Axis(loop, float(g), first=float(r.uniform(low, high)), zeta=float(r.uniform(0.45, 1)))
            for g in gains]  # fmt: skip
    late = round(float(r.uniform(0.01, 0.12)), 3)
    v, omega = float(r.uniform(0.3, 1.0)), float(r.uniform(0.6, 1.5))
    noise = float(10 ** r.uniform(-2.8, -2)) * np.array([v, omega])
    drive = Drive(float(r.choice([40.0, 60.0])), float(r.choice([0.01, 0.02, 0.04])),
                  most=(v, omega), noise=(noise[0], noise[1]))  # fmt: skip
    return Truth((axes[0], axes[1]), (late, late)), drive


def of(truth: Mapping[str, object] = {}, **drive: object) -> Callable[[np.random.Generator], Drawn]:
    """Variant of a kind, with other numbers of the base or of the drive."""

    def drawn(r: np.random.Generator) -> Drawn:
        base, way = first(r)
        return replace(base, **truth), replace(way, **drive)

    return drawn


def both(
    numbers: Callable[[np.random.Generator, float], Mapping[str, float]], seconds: float = 60.0
) -> Callable[[np.random.Generator], Drawn]:
    """Variant of a kind, with other numbers of each axis, given its largest command."""

    def drawn(r: np.random.Generator) -> Drawn:
        base, way = first(r)
        v, omega = (
            replace(a, **numbers(r, most)) for a, most in zip(base.axes, way.most, strict=True)
        )
        return replace(base, axes=(v, omega)), replace(way, seconds=seconds)

    return drawn


def pushed(r: np.random.Generator) -> Drawn:
    """A slow push."""
    base, way = first(r)
    size = r.uniform(0.02, 0.06) * np.array(way.most)
    return base, replace(way, push=(size[0], size[1], float(r.uniform(0.2, 0.8))))


def noisy(r: np.random.Generator) -> Drawn:
    """Noise of 6 % of the largest command."""
    base, way = first(r)
    return base, replace(way, noise=(0.06 * way.most[0], 0.06 * way.most[1]))


def wheels(least: float, most: float) -> Callable[[np.random.Generator], Drawn]:
    """Wheels with a least or a largest speed, as shares of the speed that both commands require."""

    def drawn(r: np.random.Generator) -> Drawn:
        base, way = first(r)
        half = float(r.uniform(0.1, 0.25))
        asked = way.most[0] + half * way.most[1]
        limits = {"least_wheel": least * asked, "most_wheel": most * asked}
        return replace(base, half_track=half, **limits), replace(way, seconds=60.0)

    return drawn


def ceasing(r: np.random.Generator) -> Drawn:
    """Commands that end, and a base that stops by itself."""
    base, way = first(r)
    way = replace(way, period=0.05, held=(0.5, 1.2), silent=(4.0, 8.0), seconds=64.0)
    return replace(base, timeout=round(float(r.uniform(0.3, 1.0)), 2)), way


def falling(r: np.random.Generator) -> Drawn:
    """Gain that falls with time."""
    base, way = first(r)
    return replace(base, then=(float(r.uniform(12, 28)), int(r.integers(2)), 0.8)), way


def averaging(r: np.random.Generator) -> Drawn:
    """Sensor that measures a moving mean."""
    base, way = first(r, str(r.choice(["second-order", "pi"])))
    return replace(base, mean=float(r.uniform(0.05, 0.2))), way


GOOD: Mapping[str, Callable[[np.random.Generator], Drawn]] = {
    "first": first,
    "ramp": both(lambda r, most: {"accel": most * r.uniform(1.5, 3)}),
    "second": lambda r: first(r, "second-order"),
    "pi": lambda r: first(r, "pi"),
    "push": pushed,
    "slow rows": of(period=0.1, held=(0.6, 2.0)),
    "short steps": of(held=(0.3, 0.8)),
    "coarse": of(quantum=0.01, period=0.01),
    "noisy": noisy,
    "levels": of(kind="levels", jitter=4e-3, period=0.02),
    "smooth": of(kind="smooth"),
    "dead band": both(lambda r, most: {"dead": most * r.uniform(0.15, 0.3)}),
}
BAD: Mapping[str, Callable[[np.random.Generator], Drawn]] = {
    "ramps apart": both(
        lambda r, m: {"accel": m * r.uniform(0.8, 1.5), "decel": m * r.uniform(3, 5)}
    ),
    "offset": both(lambda r, most: {"offset": most * r.uniform(0.12, 0.3)}),
    "ramps, offset": both(
        lambda r, m: {"accel": m * 1.2, "decel": m * 2.5, "offset": m * r.uniform(0.1, 0.2)}
    ),
    "saturation": both(lambda r, most: {"most": most * r.uniform(0.6, 0.8)}),
    "sides": both(lambda r, most: {"back": r.choice([0.8, 0.85, 1.15, 1.2])}),
    "curve": both(lambda r, most: {"curve": r.uniform(0.25, 0.6) / most}),
    "sinks": both(lambda r, most: {"curve": -r.uniform(0.2, 0.4) / most}),
    "bias": both(lambda r, most: {"bias": most * r.choice([-0.1, 0.1])}),
    "gain falls": falling,
    "least wheel": wheels(0.12, NONE),
    "most wheel": wheels(0.0, 0.6),
    "cross": of({"cross": 0.4}),
    "off once": of(off=((12.0, 22.0),), seconds=60.0),
    "off twice": of(off=((10.0, 18.0), (40.0, 50.0)), seconds=60.0),
    "zeros": of(zeros=0.08),
    "spikes": of(spikes=6),
    "cease": ceasing,
    "timer": of(timer=True, period=0.033),
    "lost": of(lost=0.3, period=0.05),
    "clock slows": of(slows=20.0),
    "millimetres": of(scale=(1000.0, 1.0)),
    "per cent": of(scale=(100.0, 1.0)),
    "equal stamps": of(twice=200),
    "sensor": lambda r: (replace(first(r, "second-order")[0], sensor=0.08), first(r)[1]),
    "sensor of means": averaging,
}
KINDS = {**GOOD, **BAD}


def first_seed(kind: str) -> int:
    """First seed of a kind; every third kind has its own seeds."""
    return LATER_SEEDS if [*KINDS].index(kind) % 3 == 2 else SEEDS
