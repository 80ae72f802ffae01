"""All statements of the filter that are tried, and the combinations that it refuses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from wmr_ctrl.control.filter import filter_system
from wmr_ctrl.core.errors import ScenarioError

from .compiled import WIDE_TURNS, Statement, T, scenario
from .first_order import (
    APART,
    BY_SIDE,
    CHAINS,
    EXACT_CHAINS,
    EXACT_WORLDS,
    LATE_APART,
    RAMPS,
    RIMS,
    SCALES,
    STOPPING,
    WHEEL_SCALES,
    WHEEL_SIDES,
    WHEELED,
    WHEELS,
    WORLDS,
    alike,
    bands_broken,
    dead_bands,
    first_order,
    rims_broken,
    sides_broken,
    wrong,
)
from .linear import (
    ALL_PI,
    ALL_SWUNG,
    ANY_TIME,
    BEAT,
    BODY_PI,
    EARLY,
    ERRING_PI,
    FAR_FROM_SWAYING,
    FREE_PI,
    FREE_SWUNG,
    HARD_SWUNG,
    LATER,
    LATER_SWUNG,
    LONG,
    LOSSY,
    ONE_PI,
    ONE_SLOW,
    ONE_SWUNG,
    PI,
    RIM_SWUNG,
    SLOW_SWUNG,
    SWAYED_PI,
    SWAYED_SWUNG,
    SWAYING,
    SWUNG,
    SWUNG_SIDES,
    Calls,
    Family,
    beyond,
    linear,
    pushed,
)

STATEMENTS = (
    Statement("clip, bases that never overshoot", first_order("clip", CHAINS, {}, SCALES), {
        "push": wrong("clip", d=0.0525), "gain": wrong("clip", gain=(0.9, 1.155)),
    }),
    Statement("clip, `wheel_speed`", first_order(
        "clip", [*alike(CHAINS), {"tau": (0.2, 0.2)}], RIMS, WHEEL_SCALES), rims_broken("clip"),
    ),
    Statement("clip, `wheel_speed` behind ramps", first_order("clip", RAMPS, RIMS, WHEEL_SCALES), {
        "gain": wrong("clip", STOPPING, RIMS, gain=(0.9, 1.155)),
        "v stops too slowly": wrong("clip", STOPPING, RIMS, decel=(1.9, 8.0)),
        "omega stops too slowly": wrong("clip", STOPPING, RIMS, decel=(2.0, 7.6)),
    }),
    Statement("clip, wheels that are not alike", first_order(
        "clip", alike(CHAINS, "wheels"), WHEELS, WHEEL_SCALES), {
        "push": wrong("clip", WHEELED, WHEELS, d=0.0525),
        "gain": wrong("clip", WHEELED, WHEELS, gain=(0.9, 1.155)),
    }),
    Statement("clip, PI loops", linear("clip", PI, PI), {
        "mass": beyond("clip", PI, ("M", 1)), "kp": beyond("clip", PI, ("kp", -1)),
        "ki": beyond("clip", PI, ("ki", 1)), "push": pushed("clip", PI),
    }),
    Statement("clip, PI loops, both axes, lost and late commands that are off", linear(
        "clip", ERRING_PI, ERRING_PI, LOSSY, of="body"), {
        "error": linear("clip", ERRING_PI, replace(ERRING_PI, error=0.315), of="body"),
        "all three": beyond("clip", ERRING_PI, *ALL_PI, of="body"),
    }),
    Statement("clip, second-order loops", linear("clip", SWUNG, SWUNG), {
        "damping": beyond("clip", SWUNG, ("z", -1)), "gain": beyond("clip", SWUNG, ("K", 1)),
        "push": pushed("clip", SWUNG),
    }),
    Statement("clip, second-order loops, a limit of each direction", linear(
        "clip", SWUNG, SWUNG, changes=SWUNG_SIDES), {
        "damping": beyond("clip", SWUNG, ("z", -1), changes=SWUNG_SIDES),
        "gain": beyond("clip", SWUNG, ("K", 1), changes=SWUNG_SIDES),
        "push": pushed("clip", SWUNG, changes=SWUNG_SIDES),
    }),
    Statement("clip, second-order loops, `wheel_speed`", linear(
        "clip", RIM_SWUNG, RIM_SWUNG, of="rims", changes=RIMS, scales=WHEEL_SCALES), {
        "damping": beyond("clip", RIM_SWUNG, ("z", -1), of="rims", changes=RIMS),
        "gain": beyond("clip", RIM_SWUNG, ("K", 1), of="rims", changes=RIMS),
        "push": pushed("clip", RIM_SWUNG, of="rims", changes=RIMS),
        "loops apart": linear("clip", RIM_SWUNG, RIM_SWUNG, of="unlike rims", changes=RIMS),
    }),
    Statement("clip, second-order loops, wheels that are not alike", linear(
        "clip", RIM_SWUNG, RIM_SWUNG, of="wheels", changes=WHEELS, scales=WHEEL_SCALES), {
        "damping": beyond("clip", RIM_SWUNG, ("z", -1), of="wheels", changes=WHEELS),
        "gain": beyond("clip", RIM_SWUNG, ("K", 1), of="wheels", changes=WHEELS),
    }),
    Statement("clip of slow commands, second-order loops", linear("clip", SLOW_SWUNG, SLOW_SWUNG), {
        "gain": beyond("clip", SLOW_SWUNG, ("K", 1)),
        "damping": beyond("clip", SLOW_SWUNG, ("z", -1)),
        "all three": beyond("clip", SLOW_SWUNG, *ALL_SWUNG),
    }),
    Statement("clip of slow commands, a second-order loop that is known", linear(
        "clip", ONE_SLOW, ONE_SLOW, LONG), {
        name: beyond("clip", ONE_SLOW, end, calls=LONG)
        for name, end in zip(("damping", "gain", "frequency"), ALL_SWUNG, strict=True)
    }),
    *(Statement(f"clip of slow commands, {name} loops, both axes, lost, late and not in time",
                linear("clip", family, family, SWAYING, of="body", changes=WIDE_TURNS), {
        "all three": beyond("clip", family, *ends, calls=SWAYING, of="body", changes=WIDE_TURNS),
        **{what: linear("clip", family, family, replace(SWAYING, **calls), of="body",
                        changes=WIDE_TURNS)
           for what, calls in FAR_FROM_SWAYING.items()},
    }) for name, family, ends in (("second-order", SWAYED_SWUNG, ALL_SWUNG),
                                  ("PI", SWAYED_PI, ALL_PI))),
    Statement("clip in single precision, bases that never overshoot", first_order(
        "clip", CHAINS, {}, SCALES, float32=True), {
        "gain": wrong("clip", gain=(0.9, 1.155)),
    }),
    Statement("clip in single precision, `wheel_speed`", first_order(
        "clip", alike(CHAINS), RIMS, WHEEL_SCALES, float32=True), {
        "gain": wrong("clip", {"loops": "alike"}, RIMS, gain=(0.9, 1.155)),
    }),
    Statement("clip in single precision, second-order loops, wheels that are not alike", linear(
        "clip", RIM_SWUNG, RIM_SWUNG, of="wheels", changes=WHEELS, scales=WHEEL_SCALES,
        float32=True), {
        "damping": beyond("clip", RIM_SWUNG, ("z", -1), of="wheels", changes=WHEELS, float32=True),
    }),
    *(Statement(f"{kind}, a limit of each direction", first_order(kind, worlds, BY_SIDE, SCALES),
                sides_broken(kind, BY_SIDE))
      for kind, worlds in (("clip", EXACT_CHAINS), ("governor", EXACT_WORLDS))),
    *(Statement(f"{kind} in single precision, a limit of each direction", first_order(
        kind, worlds, BY_SIDE, SCALES, float32=True), {
        "push": wrong(kind, {}, BY_SIDE, d=0.0525),
    }) for kind, worlds in (("clip", EXACT_CHAINS), ("governor", EXACT_WORLDS))),
    *(Statement(f"{kind}, wheels, a limit of each direction", first_order(
        kind, alike(worlds, "wheels"), WHEEL_SIDES, WHEEL_SCALES),
        sides_broken(kind, WHEEL_SIDES, "wheels"))
      for kind, worlds in (("clip", CHAINS), ("governor", WORLDS))),
    *(Statement(f"{kind}, {what}", dead_bands(kind, **stated), bands_broken(kind, **stated))
      for what, stated in (("dead bands", {}), ("`least`", {"least": True}))
      for kind in ("clip", "governor")),
    Statement("governor, first-order bases", first_order("governor", WORLDS, {}, SCALES), {
        "push": wrong("governor", d=0.0525), "time constant": wrong("governor", tau=(0.19, 0.3)),
        "gain": wrong("governor", gain=(0.9, 1.155)), "odometry": wrong("governor", error=0.021),
        "delay, by 5 % of a period": wrong("governor", delay=(0.0, 0.0025)),
        "one loss": wrong("governor", losses=1), "jitter, of 5 %": wrong("governor", jitter=0.0025),
        "a second lag of 5 ms": wrong("governor", second_lag=0.005),
        "hold": wrong("governor", {"hold": 0.12}, hold=0.126),
    }),
    Statement("governor, bounds by axis", first_order(
        "governor", [APART, LATE_APART], {}, SCALES), {
        "gain of v": wrong("governor", APART, gain=((0.95, 1.1025), (0.8, 1.5))),
        "gain of omega": wrong("governor", APART, gain=((0.95, 1.05), (0.8, 1.575))),
        "tau of omega": wrong("governor", APART, tau=((0.1, 0.15), (0.38, 0.6))),
    }),
    Statement("governor, `wheel_speed`", first_order("governor", alike(WORLDS), RIMS, WHEEL_SCALES),
              rims_broken("governor", **{
        "gains apart": {"loops": "body", "tau": (0.2, 0.2), "gain": (1.045, 1.1)},
        "time constant": {"tau": (0.19, 0.3)}, "odometry": {"error": 0.021},
        "one loss": {"losses": 1},
    })),
    Statement("governor, wheels that are not alike", first_order(
        "governor", alike(WORLDS, "wheels"), WHEELS, WHEEL_SCALES), {
        "push": wrong("governor", WHEELED, WHEELS, d=0.0525),
        "gain": wrong("governor", WHEELED, WHEELS, gain=(0.9, 1.155)),
        "time constant": wrong("governor", WHEELED, WHEELS, tau=(0.19, 0.3)),
    }),
    Statement("governor in single precision, `wheel_speed`", first_order(
        "governor", alike(WORLDS), RIMS, WHEEL_SCALES, float32=True), {
        "time constant": wrong("governor", {"loops": "alike"}, RIMS, tau=(0.19, 0.3)),
    }),
    Statement("band, PI loops", linear("band", FREE_PI, FREE_PI), {
        "mass": beyond("band", FREE_PI, ("M", 1)), "kp": beyond("band", FREE_PI, ("kp", -1)),
        "ki": beyond("band", FREE_PI, ("ki", 1)),
        "all three": beyond("band", FREE_PI, *ALL_PI),
    }),
    Statement("band, PI loops, both axes by one factor, commands that are off", linear(
        "band", ERRING_PI, ERRING_PI, of="body"), {
        "error": linear("band", ERRING_PI, replace(ERRING_PI, error=0.315), of="body"),
        "all three": beyond("band", ERRING_PI, *ALL_PI, of="body"),
    }),
    Statement("band, PI loops, both axes not by one factor", linear(
        "band", BODY_PI, BODY_PI, of="body", scales=SCALES[::2]), {
        "all three": beyond("band", BODY_PI, *ALL_PI, of="body", scales=SCALES[:1]),
    }),
    Statement("band in single precision, PI loops", linear("band", PI, PI, float32=True), {
        "all three": beyond("band", PI, *ALL_PI, float32=True),
    }),
    Statement("band, PI loops, steps within jitter of the beat, untold", linear(
        "band", BEAT, BEAT, Calls("beat", jitter=T / 10, telling=False)), {
        "all three": beyond("band", BEAT, *ALL_PI, calls=Calls("beat", jitter=T / 10)),
        "steps early by a quarter of a period": linear("band", BEAT, BEAT, EARLY),
    }),
    Statement("band, PI loops, steps at any time", linear("band", FREE_PI, FREE_PI, ANY_TIME), {
        "times not told": linear("band", FREE_PI, FREE_PI, replace(ANY_TIME, telling=False)),
        "all three": beyond("band", FREE_PI, *ALL_PI, calls=ANY_TIME),
    }),
    Statement("band, PI loops that are pushed", linear("band", PI, PI), {
        "push": pushed("band", PI), "all": beyond("band", PI, *ALL_PI),
    }),
    Statement("band, a PI loop that is known and pushed", linear("band", ONE_PI, ONE_PI), {
        "push": pushed("band", ONE_PI),
    }),
    Statement("band, second-order loops", linear("band", FREE_SWUNG, FREE_SWUNG), {
        "damping": beyond("band", FREE_SWUNG, ("z", -1)),
        "gain": beyond("band", FREE_SWUNG, ("K", 1)),
        "frequency": beyond("band", FREE_SWUNG, ("w0", -1)),
        "all three": beyond("band", FREE_SWUNG, *ALL_SWUNG),
    }),
    Statement("band, second-order loops that are pushed", linear("band", SWUNG, SWUNG), {
        "push": pushed("band", SWUNG),
        "all": beyond("band", SWUNG, *ALL_SWUNG),
    }),
    Statement("band in single precision, second-order loops that are pushed", linear(
        "band", SWUNG, SWUNG, float32=True), {
        "all": beyond("band", SWUNG, *ALL_SWUNG, float32=True),
    }),
    Statement("band, second-order loops, commands late by a constant time", linear(
        "band", LATER_SWUNG, LATER_SWUNG, LATER), {
        "ten losses": linear("band", LATER_SWUNG, LATER_SWUNG, replace(LATER, losses=10)),
        "all three": beyond("band", LATER_SWUNG, *ALL_SWUNG, calls=LATER),
    }),
    Statement("band, second-order loops that are pushed hard", linear(
        "band", HARD_SWUNG, HARD_SWUNG), {"push": pushed("band", HARD_SWUNG)},
    ),
    Statement("band, a second-order loop that is known", linear("band", ONE_SWUNG, ONE_SWUNG), {
        "frequency too low": beyond("band", ONE_SWUNG, ("w0", -1)),
        "frequency too high": beyond("band", ONE_SWUNG, ("w0", 1)),
    }),
)  # fmt: skip


ITS_WHEELS: Sequence[Mapping[str, Any]] = ({"channels": "wheels"}, {"wheel_speed": 1.0})
REFUSED: Sequence[tuple[str, str, Family | None, Sequence[Mapping[str, Any]]]] = (
    ("governor of second-order loops", "governor", SWUNG, [{}]),
    ("governor of PI loops", "governor", PI, [{}]),
    ("band of first-order loops", "band", None, [{}]),
    ("band with losses", "band", SWUNG, [{"losses": 1}]),
    ("band, a base that stops by itself", "band", SWUNG, [{"hold": 0.5}]),
    ("band, a delay that varies", "band", SWUNG, [{"delay": (0.0, 0.02)}]),
    ("band with odometry, or of wheels", "band", SWUNG, [{"odometry": (0.1, 0.1)}, *ITS_WHEELS]),
    ("clip, PI loops of wheels", "clip", PI, ITS_WHEELS),
    ("band with `slew`", "band", SWUNG, [{"slew": (0.1, 0.1)}]),
    ("clip with `slew`, a base that stops by itself, or of wheels", "clip", SLOW_SWUNG,
     [{"hold": 0.5}, *ITS_WHEELS]),
    ('clip with `scale = "axes"`, of wheels', "clip", SWUNG,
     [{"scale": "axes", **own} for own in ITS_WHEELS]),
)  # fmt: skip
"""Combinations that are refused: in words, then a filter's kind, family and further keys."""


def refusals() -> str:
    """Markdown list of the cases in which a filter is refused."""
    return "\n".join(f"- {what}" for what, *_ in REFUSED)


def refused(number: int) -> bool:
    """Whether every filter of a row of REFUSED is."""
    _, kind, family, every = REFUSED[number]
    return all(_refused(kind, {**(family.told if family else {}), **own}) for own in every)


def _refused(kind: str, stated: Mapping[str, Any]) -> bool:
    try:
        filter_system(scenario(kind, **stated))
    except ScenarioError:
        return True
    return False
