"""The closed loop of a setup as CasADi functions, for a machine without a compiler."""

from dataclasses import dataclass
from pathlib import Path

from wmr_ctrl.control.loop import CLOCK, COUNTED
from wmr_ctrl.control.setup import Setup
from wmr_ctrl.core.compiled import CompiledLoop
from wmr_ctrl.world.effect import Rate
from wmr_ctrl.world.model.evaluate import InPlace

from .build import filled, program_of
from .kernels import logged_kernels


@dataclass(frozen=True)
class StreamNumbers:
    """A stream of random numbers: its index in the generator's counter, and its size.

    ``held``: a sample's numbers are kept over its plant steps; ``wanted``: if false they are 0;
    ``bound``: of normal numbers.
    """

    number: int
    size: int
    normal: bool
    held: bool
    wanted: bool
    bound: float


@dataclass(frozen=True)
class LoopFunctions:
    """A loop's graphs as functions that CasADi evaluates in place, with a scenario's numbers.

    ``sample``: from (k, x, p, draws) to the next slow state, the held values, and the log's row;
    ``step``: from (step, held, fast state, p, draws) to the next fast state; ``sampled`` and
    ``stepped``: streams of both rates; ``limits``: those of CLOCK, beyond which a step counts.
    """

    numbers: CompiledLoop
    sample: InPlace
    step: InPlace
    sampled: tuple[StreamNumbers, ...]
    stepped: tuple[StreamNumbers, ...]
    limits: tuple[float, ...]


def loop_functions(setup: Setup) -> LoopFunctions:
    """The closed loop of a setup for a machine without a compiler."""
    program = program_of(setup)
    loop = program.loop
    functions = {item.name: item.function for item in logged_kernels(loop)}
    numbers = filled(program, setup, Path(), "")
    clock = functions["clock"](numbers.parameters[0]).full().ravel().tolist()
    said = iter(clock[len(CLOCK) :])
    rates: dict[Rate, list[StreamNumbers]] = {Rate.SAMPLE: [], Rate.STEP: []}
    for item in loop.streams:
        made = (item.number, item.size, item.normal, item.draw.held)
        rates[item.rate].append(StreamNumbers(*made, wanted=next(said) != 0.0, bound=next(said)))
    limits = tuple(clock[CLOCK.index(COUNTED[0]) : len(CLOCK)])
    sample, step = map(InPlace.with_arrays, (functions["sample_logged"], functions["step"]))
    streams = tuple(rates[Rate.SAMPLE]), tuple(rates[Rate.STEP])
    return LoopFunctions(numbers, sample, step, *streams, limits)
