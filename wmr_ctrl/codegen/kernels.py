"""The kernels of one closed loop: which graphs become C, under which names, with which sizes."""

from __future__ import annotations

from collections.abc import Mapping

from wmr_ctrl.codegen.emit import Kernel, kernel
from wmr_ctrl.control.loop import CLOCK, SEEN, SUMS, LoopGraphs
from wmr_ctrl.model.system import System, values
from wmr_ctrl.signals import VELOCITY
from wmr_ctrl.world.effect import Rate

FINDINGS = (
    "max_v1", "max_omega", "violations", "first_step", "first_axis", "stop", "stop_step",
    "stop_axis", "samples", "torque", "d_least1", "d_least2", "left_sample", "left_axis",
    "clipped1", "clipped2",
)  # fmt: skip
"""What a run leaves: largest |v| [m/s, rad/s]; plant steps beyond a limit, step and axis of the
first (-1, 0); reason, step and axis of an early end; samples made; and of runs without a log the
largest |torque| [N m] and d_least [N, N m], sample and axis of the first beyond its bound (-1, 0),
samples with the clip active."""


def loop_kernels(loop: LoopGraphs) -> tuple[Kernel, ...]:
    """The C functions that the runtime calls."""
    given = {"k": loop.k.sym, "x": loop.x, "p": loop.p, "w": loop.draws(Rate.SAMPLE)}
    left = {"next": loop.next_slow, "held": loop.held}
    return (
        kernel("clock", "Numbers that the loop itself takes.", {"p": loop.p}, {"n": loop.clock}),
        kernel("sample_logged", "A control sample with its log.", given, {**left, "row": loop.row}),
        kernel(
            "sample_watched", "A control sample and what is watched.", given,
            {**left, "seen": loop.seen},
        ),
        kernel(
            "step", "The fast state after one plant step.",
            {
                "i": loop.i.sym, "u": loop.u.sym, "x": loop.x_fast, "p": loop.p,
                "w": loop.draws(Rate.STEP),
            },
            {"next": loop.next_fast},
        ),
    )  # fmt: skip


def controller_kernel(system: System) -> Kernel:
    """One sample of the controller by itself."""
    return kernel(
        "controller", f"One sample: {system.title}.",
        {"u": system.u, "x": system.x, "p": system.p}, {"next": system.update, "y": system.y},
    )  # fmt: skip


def plant_kernel(loop: LoopGraphs) -> Kernel:
    """One plant step by itself, for measuring: the first state entries are the plant's."""
    return next(item for item in loop_kernels(loop) if item.name == "step")


def loop_constants(loop: LoopGraphs) -> Mapping[str, int | str]:
    """Sizes and places that the runtime is written against, by their names in C."""
    state = [name for item in loop.fast for name in item.signal.elements]
    sizes: dict[str, int | str] = {
        "NX": len(loop.x0),
        "NFAST": loop.next_fast.numel(),
        "NP": len(values(loop.parameters.ports)),
        "HELD": loop.held.numel(),
        "ROW": loop.row.numel(),
        "SUMS": len(SUMS),
        "SEEN": len(SEEN),
        "CLOCK": loop.clock.numel(),
        "FINDINGS": len(FINDINGS),
        "SAMPLE_DRAWS": loop.draws(Rate.SAMPLE).numel(),
        "STEP_DRAWS": loop.draws(Rate.STEP).numel(),
        "CLOCK_STREAMS": len(CLOCK),
        "STREAMS": ", ".join(map(_stream, range(len(loop.streams)), [loop] * len(loop.streams))),
    }
    sizes |= {f"AT_{s.name.upper()}": state.index(s.name) for s in VELOCITY}
    sizes |= {f"CLOCK_{name.upper()}": place for place, name in enumerate(CLOCK)}
    sizes |= {f"SEEN_{name.upper()}": place for place, name in enumerate(SEEN)}
    sizes |= {f"FOUND_{name.upper()}": place for place, name in enumerate(FINDINGS)}
    return sizes


def _stream(place: int, loop: LoopGraphs) -> str:
    """A row of the table of streams: number, whether normal, pairs, whether drawn each step."""
    item = loop.streams[place]
    return (
        f"{{{item.number}u, {int(item.normal)}, {item.size // 2}, {int(item.rate is Rate.STEP)}}}"
    )


def sizes_of(role: str, system: System) -> Mapping[str, int]:
    """Lengths of a System's vectors, under the letters that C uses."""
    sizes = {
        "NU": system.u.numel(),
        "NX": system.x.numel(),
        "NP": len(values(system.params)),
        "NY": system.y.numel(),
        "ND": system.d.numel(),
    }
    return {f"{role.upper()}_{key}": count for key, count in sizes.items()}
