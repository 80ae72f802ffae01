"""Certificate: the statement of a corridor, as plain data."""

from dataclasses import dataclass

import casadi as ca

from .intervals import Floats


@dataclass(frozen=True)
class Certificate:
    """A corridor's statement: a box for each sample, around the undisturbed loop's trajectory.

    The K samples are consecutive.  If ``lags`` is 0, K is 1 and the one sample repeats for ever.
    ``law`` and ``step``: graphs of a column of variables and a column of numbers.  ``sizes``: the
    limits of the conditions, as a function of the law's columns.  A state has the fast state,
    ``queue`` commands sent, ``memory`` and ``acting``.  The law's variables are e and v, memory,
    queue and acting; its outputs are command, memory, acting, and the conditions' values.  A plant
    step's variables are fast state, command, push and body.  A command acts ``late`` plant steps
    after its sample.  In the plant steps after that a ``share`` of the previous command acts, with
    an error of ``off`` (steps, 2) times the difference of both.

    Trajectory: ``states`` (K + 1, n), ``fine`` (K, steps + 1, fast), ``outs`` (K, outputs without
    conditions), ``body`` (K, steps, 2), ``law_numbers`` (K, any), ``step_numbers`` (K, steps, any).

    Inputs: ``push`` (2), ``pose``, ``reckoned`` (3), ``velocity`` (2), ``wide`` (2, body).
    ``command`` (2): error of an acting command; ``dead`` (2): further error of a command that a
    dead band may remove.  Errors of the reference: ``law_gap`` (outputs), ``step_gap`` (fast) in
    every plant step, ``gap`` (K, n) at a sample's end; ``aside`` (K, 2): its distance [m, rad] from
    its place within a sample.  ``start`` (n, any): initial deviations.  ``disc``: radius of a
    further one, and its place in the state.  ``lower`` (conditions): the margin that measurement
    errors take from the limits.

    Box: ``fast`` (K, rows): elements, directions, sums and differences of ``pairs`` with their
    ``ratios``; ``state`` (K + 1, n) at samples; ``out`` (K, any) of command and conditions.

    ``knots``: plant steps at which rows are evaluated; ``lags``: number of samples whose inputs are
    kept separate.
    """

    law: ca.Function
    step: ca.Function
    sizes: ca.Function
    queue: int
    memory: int
    acting: int
    late: int
    share: Floats
    off: Floats
    states: Floats
    fine: Floats
    outs: Floats
    body: Floats
    law_numbers: Floats
    step_numbers: Floats
    push: Floats
    pose: float
    reckoned: Floats
    velocity: Floats
    wide: Floats
    command: Floats
    dead: Floats
    law_gap: Floats
    step_gap: Floats
    gap: Floats
    aside: Floats
    start: Floats
    disc: tuple[float, int]
    lower: Floats
    pairs: list[tuple[int, int]]
    ratios: Floats
    fast: Floats
    state: Floats
    out: Floats
    knots: list[int]
    lags: int
