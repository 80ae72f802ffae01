"""A compiled loop as plain data, so that code that only runs it need not import CasADi."""

from dataclasses import dataclass

from .signals import Signal

Signals = tuple[Signal, ...]


@dataclass(frozen=True)
class LawLayout:
    """Inputs, memory and parameters of the controller alone."""

    inputs: Signals
    state: Signals
    parameters: Signals
    start: tuple[float, ...]
    values: tuple[float, ...]


@dataclass(frozen=True)
class LoopLayout:
    """Meaning of the vectors in a loop's library; equal for all scenarios of one structure.

    ``columns``: signals of the log.  ``findings`` and ``sums``: names of the results of a run
    without a log.
    """

    title: str
    columns: Signals
    state: Signals
    parameters: Signals
    findings: tuple[str, ...]
    sums: tuple[str, ...]


@dataclass(frozen=True)
class CompiledLoop:
    """A law's closed loop on a scenario: library, layout, and the numbers of this scenario.

    ``parameters`` has a row for each phase, which begins at plant step ``phase_start``; ``start``
    is the whole state at t = 0; ``delay_steps`` is the number of plant steps that a command is in
    transit.  ``digest`` is the hash of the sources; loops of one ``structure`` can run side by
    side.
    """

    library: str
    digest: str
    structure: str
    layout: LoopLayout
    law: LawLayout
    parameters: tuple[tuple[float, ...], ...]
    phase_start: tuple[int, ...]
    start: tuple[float, ...]
    delay_steps: int
