"""Effects of a base that takes velocities on its commands, and paths that demand more."""

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.results import Run
from wmr_ctrl.results.remarks import HELD_BACK, percent
from wmr_ctrl.results.verdicts import Warning
from wmr_ctrl.world.references.kind import GRID, sample
from wmr_ctrl.world.scenario import Scenario

from .error_coordinates import Floats
from .loop import Loop

Bools: TypeAlias = NDArray[np.bool_]
STILL = 1e-9
"""Speed [m/s, rad/s] that counts as none."""
SAME = 1e-6
"""Share by which a path may turn tighter than the base and yet as tightly."""


def rims(scenario: Scenario, pairs: Floats) -> Floats:
    """Speeds of the right and left rim (n, 2) [m/s] for (v, omega) (n, 2)."""
    return pairs @ np.array([[1.0, 1.0], [scenario.robot.l, -scenario.robot.l]])


def dead(scenario: Scenario, pairs: Floats) -> dict[str, Bools]:
    """Masks of nonzero commands (n, 2) inside a dead band, by the band's key."""
    base = scenario.base
    bands = {
        "base.deadband": (pairs, np.array(base.deadband)),
        "base.wheel_deadband": (rims(scenario, pairs), np.array(base.wheel_deadband)),
    }
    return {
        key: ((np.abs(asked) < band) & (np.abs(asked) > STILL)).any(axis=1)
        for key, (asked, band) in bands.items()
        if band.any()
    }


def beyond_base(loop: Loop) -> Iterator[Warning]:
    """Warn if the path turns more tightly than the base can, or needs commands inside its dead
    band.
    """
    scenario = loop.scenario
    if not loop.setup.takes_velocity:
        return
    end = min(scenario.clock.duration, scenario.reference.cycle)
    pairs = sample(scenario, np.linspace(0, end, GRID))[:, 3:5]
    turns, least = pairs[np.abs(pairs[:, 1]) > STILL], scenario.base.min_radius
    tightest = float(np.min(np.abs(turns[:, 0] / turns[:, 1]), initial=np.inf))
    if tightest < least * (1 - SAME):
        yield Warning(
            "base.min_radius",
            f"the path turns with a radius of {tightest:.3g} m, tighter than base.min_radius = "
            f"{least:g} m: the base leaves it there. Ask for wider turns.",
            "docs/howto/velocity_base.md",
        )
    for key, within in dead(scenario, pairs).items():
        if (share := float(within.mean())) >= HELD_BACK:
            yield Warning(
                key,
                f"for {percent(share)} of its time the path asks for less than {key}, and such "
                "commands have no effect: the base leaves the path until the law asks for more. "
                "Ask for a faster or tighter path.",
                "docs/howto/velocity_base.md",
                objects=False,
            )


LAST = 10.0
"""Time [s] at the end of a run in which causes are looked for."""
SHARE = 0.1
"""Change of a command, as a share of the limits, that is missed where it is lost."""
REMEDIES = {
    "dead-band": "set filter.least = true, raise the law's gains, or ask for a faster path",
    "wheel-limit": "ask for a slower path, or lower limits.v_u1",
    "quantum": "raise the law's gains, or ask for a faster path",
    "ramps": "lower the law's gains, or ask for a smoother path",
    "losses": "lower the law's gains, or mend the link",
}


def _done(scenario: Scenario, u: Floats) -> Iterator[tuple[str, str, Bools]]:
    """For each cause: its key, its effect on commands (n, 2) as text, and the affected rows."""
    base, T, w = scenario.base, scenario.clock.control, rims(scenario, u)

    def changed(asked: Floats, periods: int = 1) -> Floats:
        return np.abs(asked[periods:] - asked[:-periods])

    for key, within in dead(scenario, u).items():
        yield "dead-band", f"less than {key}", within
    yield "wheel-limit", "more than base.w_max", np.abs(w) > scenario.robot.r * base.w_max
    rounded = (np.abs(u) < np.array(base.quantum) / 2) & (np.abs(u) > STILL)
    yield "quantum", "less than half of base.quantum", rounded
    rates = np.maximum(base.accel, base.decel), max(base.wheel_accel, base.wheel_decel)
    for asked, rate, names in zip((u, w), rates, ("accel", "wheel_accel"), strict=True):
        yield "ramps", f"faster changes than base.{names}", _ramping(asked, T * rate)
    if base.losses:
        most = SHARE * np.array(scenario.limits.v_u1)
        said = f"changes by a tenth of the limits within base.losses = {base.losses} commands"
        yield "losses", said, changed(u, base.losses) > most


def _ramping(asked: Floats, most: Floats | float) -> Bools:
    """Mask (n, 2) of rows in which a base from rest, limited to ``most`` a sample, lags behind."""
    acting, off = np.zeros(2), np.empty_like(asked)
    for row, command in enumerate(asked):
        off[row] = command - acting
        acting += np.clip(off[row], -most, most)
    return np.abs(off) > most * (1 + SAME)


def causes(scenario: Scenario, run: Run) -> dict[str, str]:
    """Effects of the base on the commands at a run's end, as sentences by the remark's key."""
    if not scenario.takes_velocity or "v_command" not in run:
        return {}
    count = min(run.rows, round(LAST / scenario.clock.control))
    u = np.stack([run[name] for name in ("v_command", "omega_command")], axis=1)
    ends = ((key, what, rows[-count:]) for key, what, rows in _done(scenario, u))
    shares = ((key, what, float(np.mean(rows.reshape(len(rows), -1).any(axis=1))))
              for key, what, rows in ends if len(rows))  # fmt: skip
    return {
        key: f"For {percent(share)} of the last {count * scenario.clock.control:g} s the law asked "
        f"for {what}: {REMEDIES[key]}."
        for key, what, share in shares
        if share >= HELD_BACK
    }
