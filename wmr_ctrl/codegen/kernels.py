"""The kernels of one closed loop: graphs to translate to C, their names and sizes."""

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca

from wmr_ctrl.control.loop import (
    CLOCK,
    GAP,
    SEEN,
    SUMS,
    WINDOW,
    Graphs,
    LoopGraphs,
    PlantlessGraphs,
)
from wmr_ctrl.control.wiring import Stream
from wmr_ctrl.core.signals import VELOCITY
from wmr_ctrl.world.effect import Rate
from wmr_ctrl.world.model.system import System, stack, values
from wmr_ctrl.world.sight import way_to_point

from .emit import Kernel, kernel

FINDINGS = (
    "max_v1", "max_omega", "margin_v1", "margin_omega", "violations", "first_step", "first_axis",
    "stop", "stop_step", "stop_axis", "samples", "torque", "d_least1", "d_least2", "left_sample",
    "left_axis", "clipped1", "clipped2",
)  # fmt: skip
"""Run results: largest |v| and least margin to the limits [m/s, rad/s]; plant steps beyond a limit,
step and axis of the first (-1, 0); reason, step and axis of an early end; samples made; and of runs
without a log the largest |torque| [N m] and d_least [N, N m], sample and axis of the first beyond
its bound (-1, 0), samples with the clip active.  With obstacles GAP comes last, its least [m]."""


def loop_kernels(loop: LoopGraphs) -> tuple[Kernel, ...]:
    """The C functions that the runtime calls."""
    clock, logged, step = logged_kernels(loop)
    given, left = _sampled(loop), {"next": loop.next_slow, "held": loop.held, "seen": loop.seen}
    meaning = "A control sample and what is watched."
    return clock, logged, kernel("sample_watched", meaning, given, left, prepared=True), step


def logged_kernels(loop: LoopGraphs) -> tuple[Kernel, Kernel, Kernel]:
    """The C functions of runs with a log."""
    left = {"next": loop.next_slow, "held": loop.held, "row": loop.row}
    moved, after = _stepped(loop), {"next": loop.next_fast}
    named = "sample_logged", "A control sample with its log."
    logged = kernel(*named, _sampled(loop), left, prepared=True)
    step = kernel("step", "The fast state after a plant step.", moved, after, prepared=True)
    return _clock(loop), logged, step


def outside_kernels(loop: PlantlessGraphs) -> tuple[Kernel, ...]:
    """The C functions of sensors, disturbances and drives, for an external controller and plant."""
    left = {"next": stack(loop.sample.following), "y": loop.measured}
    measure = kernel("measure", "What the sensors show, and what disturbs.", _sampled(loop), left)
    return _clock(loop), measure, _acting(loop)


def plantless_kernels(loop: LoopGraphs) -> tuple[Kernel, ...]:
    """The C functions of a whole loop with an external plant."""
    clock, logged, _ = logged_kernels(loop)
    return clock, replace(logged, prepared=False), _acting(loop)


def _clock(loop: Graphs) -> Kernel:
    return kernel("clock", "Numbers that the loop itself takes.", {"p": loop.p}, {"n": loop.clock})


def _acting(loop: Graphs) -> Kernel:
    moved = {"next": loop.resting, "y": loop.acting}
    return kernel("act", "What acts on the plant.", _stepped(loop), moved)


def _sampled(loop: Graphs) -> dict[str, ca.SX]:
    k, w = loop.sample.clock.sym, loop.draws(Rate.SAMPLE)
    return {"k": k, "x": loop.x, "p": loop.p, "w": w}


def _stepped(loop: Graphs) -> dict[str, ca.SX]:
    i, x = loop.step.clock.sym, stack(item.sym for item in loop.fast)
    return {"i": i, "u": loop.u.sym, "x": x, "p": loop.p, "w": loop.draws(Rate.STEP)}


def controller_kernel(system: System, name: str = "controller") -> Kernel:
    """One sample of the controller alone."""
    given, left = {"u": system.u, "x": system.x, "p": system.p}, {"next": system.update}
    return kernel(name, f"One sample: {system.title}.", given, {**left, "y": system.y})


def way_kernel() -> Kernel:
    """Distance of a disc ahead and behind to a point: the point, the window, the radius."""
    u = ca.SX.sym("u", 5)
    x, y, left, right, radius = ca.vertsplit(u)
    ways = [way_to_point((x, y), (left, right), radius, sense) for sense in (1, -1)]
    return kernel("way", "Ways of a disc to a point.", {"u": u}, {"y": ca.vertcat(*ways)})


def loop_constants(loop: LoopGraphs) -> Mapping[str, int | str]:
    """Sizes and indices that the runtime needs, by their names in C."""
    seen = (*SEEN, *_gap(loop))
    sizes = {"ROW": loop.row.numel(), "SUMS": len(SUMS), "WINDOW": len(WINDOW), "SEEN": len(seen)}
    places = {f"SEEN_{name.upper()}": place for place, name in enumerate(seen)}
    return {**sizes, **places, **_constants(loop)}


def findings_of(loop: Graphs) -> tuple[str, ...]:
    """FINDINGS of a loop, with GAP if it has obstacles."""
    return (*FINDINGS, *_gap(loop))


def _gap(loop: Graphs) -> tuple[str, ...]:
    return (GAP,) * len(loop.gap)


def outside_constants(loop: PlantlessGraphs) -> Mapping[str, int | str]:
    """Sizes and indices for sensors, disturbances and drives alone."""
    return {"MEASURED": loop.measured.numel(), **_beside_plant(loop), **_constants(loop)}


def plantless_constants(loop: LoopGraphs) -> Mapping[str, int | str]:
    """Sizes and indices for a whole loop with an external plant."""
    return {"ROW": loop.row.numel(), **_beside_plant(loop), **_constants(loop)}


def _beside_plant(loop: Graphs) -> Mapping[str, int | str]:
    return {"PLANT": loop.plant.x.numel(), "ACTING": loop.acting.numel(), "WINDOW": 0}


def _constants(loop: Graphs) -> Mapping[str, int | str]:
    state = [name for item in loop.fast for name in item.signal.elements]
    findings = findings_of(loop)
    sizes: dict[str, int | str] = {
        "STATE": len(values((*loop.fast, *loop.slow))),
        "FAST": len(state),
        "PARAMETERS": len(values(loop.parameters.ports)),
        "HELD": loop.u.sym.numel(),
        "CLOCK": loop.clock.numel(),
        "FINDINGS": len(findings),
        "SAMPLE_DRAWS": loop.draws(Rate.SAMPLE).numel(),
        "STEP_DRAWS": loop.draws(Rate.STEP).numel(),
        "CLOCK_STREAMS": len(CLOCK),
        "STREAMS": ", ".join(map(_stream, loop.streams)) or "{0u, 0, 0, 0, 0}",
    }
    sizes |= {f"AT_{s.name.upper()}": state.index(s.name) for s in VELOCITY}
    sizes |= {f"CLOCK_{name.upper()}": place for place, name in enumerate(CLOCK)}
    return sizes | {f"FOUND_{name.upper()}": place for place, name in enumerate(findings)}


def _stream(item: Stream) -> str:
    """A row of the table of streams: number, normal, pairs, per step, held."""
    flags = (int(item.rate is Rate.STEP), int(item.draw.held))
    numbers = (f"{item.number}u", int(item.normal), item.size // 2, *flags)
    return f"{{{', '.join(map(str, numbers))}}}"


def sizes_of(role: str, system: System) -> Mapping[str, int]:
    """Lengths of a System's vectors, by the letters used in C."""
    vectors = {"NU": system.u, "NX": system.x, "NP": system.p, "NY": system.y, "ND": system.d}
    return {f"{role.upper()}_{key}": vector.numel() for key, vector in vectors.items()}
