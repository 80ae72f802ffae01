"""Certificates of computed corridors, written for `wmr_proofs.corridor_check`."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT
from wmr_proofs.corridor_check.certificate import Certificate
from wmr_proofs.corridor_check.check import check, in_the_long_run
from wmr_proofs.corridor_check.intervals import RefusedError

from .certificate import Certifier
from .gains import DIRECTIONS, PAIRS
from .inputs import Inputs, NoCorridorError
from .instant import RunBounds
from .loop import LawLoop
from .passage import Passing
from .peaks import Peaks, Tube, reference_gap

ROOM = 1 + 3e-3
"""Growth of the stated box over the computed one."""
ROOMS = (1.001, 1.02, 1.06)
"""Growths that are tried for a whole run."""
LEAST = 1e-3
"""Share of the largest size in a run that is added."""
DUST = (1e-7, 1e-9, 1e-9)
"""Size that is added within a sample, at samples, and to the law's outputs.

Rates bring about the first from a box of the second at the sample's beginning.
"""
LAGS = 1.75
"""Samples that are distinguished by their age, over the run's memory; 1 more after a start."""


@contextmanager
def refused_unchecked() -> Iterator[None]:
    """Context that raises NoCorridorError with a text if the checker refuses."""
    try:
        yield
    except RefusedError as error:
        raise NoCorridorError(
            f"the bounds that were computed do not pass their check ({error}), so no width is "
            "stated; please report it with the scenario"
        ) from error


def checked(certifier: Certifier, inputs: Inputs, tube: Tube) -> Tube:
    """The tube, with the width that the checker shows; NoCorridorError if it refuses."""
    stated = of_loop(certifier, inputs, tube.peaks)
    with refused_unchecked():
        distance, turn = (float(course[0]) for course in check(stated))
        late = distance if tube.position_late == tube.position else in_the_long_run(stated)
    return replace(
        tube, position=max(tube.position, distance), heading=max(tube.heading, turn),
        position_late=max(tube.position_late, late),
    )  # fmt: skip


def checked_run(passing: Passing, bounds: RunBounds) -> RunBounds:
    """Bounds of a run, with the widths that the checker shows; NoCorridorError if it refuses."""
    with refused_unchecked():
        for room in ROOMS:
            try:
                position, heading = check(of_run(passing, bounds, room))
                break
            except RefusedError:
                if room == ROOMS[-1]:
                    raise
    position, heading = np.maximum(bounds.position, position), np.maximum(bounds.heading, heading)
    return replace(bounds, position=position, heading=heading)


def of_loop(certifier: Certifier, inputs: Inputs, peaks: Peaks) -> Certificate:
    """The Certificate of a Certifier's closed box."""
    loop, scenario = certifier.loop, certifier.loop.setup.scenario
    peaks = Peaks(*(part * ROOM + dust for part, dust in zip(peaks.parts, DUST, strict=True)))
    free = np.minimum(peaks.law[-loop.count :], (certifier.most - certifier.level) * (1 - 1e-9))
    inputs = certifier._reckoned(inputs, peaks)
    nz, n, steps = len(loop.names), len(loop.at), loop.steps
    outs = COMMAND + loop.memory + loop.acting
    start = np.hstack([certifier.start[:, :3], np.zeros((n, COMMAND))])
    if loop.observed:
        old = nz + COMMAND * loop.queue + loop.observed[1]
        start[old : old + COMMAND, 3:] = np.diag(certifier._before(inputs, certifier.law_rest))
    lost = [0.0 if x.measured is None else inputs.velocity[x.measured] for x in loop.conditions]
    law_gap, step_gap, v_d = np.zeros(outs), np.zeros(nz), loop.step.at[3:ROBOT]
    step_gap[:2] = reference_gap(v_d, scenario.clock.plant)
    if loop.filter:
        place = COMMAND + loop.memory - loop.filter
        law_gap[place : place + 2] = reference_gap(v_d, scenario.clock.control)
    none, curves = ca.SX.sym("none", 0), (loop.law, loop.step, loop.limits)
    law, step, sizes = (ca.Function("graph", [x.by, none], [x.output]) for x in curves)
    body = loop.step.at[-COMMAND:]
    return Certificate(
        law, step, sizes,
        states=np.tile(loop.at, (2, 1)), fine=np.tile(loop.at[:nz], (1, steps + 1, 1)),
        outs=loop.remains[None, :outs], body=np.tile(body, (1, steps, 1)),
        law_numbers=np.zeros((1, 0)), step_numbers=np.zeros((1, steps, 0)),
        share=loop.overlap.share, off=loop.overlap.off, law_gap=law_gap, step_gap=step_gap,
        gap=np.zeros((1, n)), aside=np.zeros((1, 2)), start=start, lower=np.array(lost),
        disc=(inputs.pose + certifier.begun, n - loop.acting - ROBOT) if loop.filter else (0.0, 0),
        pairs=PAIRS, ratios=certifier.gains.ratios,
        fast=peaks.fast[None, : nz + DIRECTIONS + 2 * len(PAIRS)],
        state=np.tile(peaks.state, (2, 1)), out=np.concatenate([peaks.law[:COMMAND], free])[None],
        knots=list(range(steps)), lags=0,
        **_known(loop, inputs),
    )  # fmt: skip


def of_run(passing: Passing, bounds: RunBounds, room: float = ROOMS[0]) -> Certificate:
    """The Certificate of a whole run with a flowpipe."""
    along, loop, motion = passing.along, passing.loop, passing.along.motion
    n, nz, outs = len(passing.pending), passing.nz, COMMAND + loop.memory + loop.acting
    fast, state, out = (
        part * room + (LEAST * part.max(axis=0) + dust) * (part > 0)
        for part, dust in zip(bounds.box, DUST, strict=True)
    )
    free = (along.most - along.levels) * (1 - 1e-9)
    sent, heard, dead = out[:, :COMMAND], bounds.box[2][:, :COMMAND], passing.inputs.dead
    edge = np.abs(along.outs[:, :COMMAND]) - dead * (1 + 1e-9)
    np.minimum(sent, edge, out=sent, where=(edge > heard) & (dead > 0))
    out[:, COMMAND:] = np.minimum(out[:, COMMAND:], free)
    gap = np.zeros((len(fast), n))
    gap[:, :2] = motion.gap[:, None]
    if loop.filter:
        place = n - loop.acting - loop.filter
        gap[:, place : place + 2] = motion.reckoned[:, None]
    return Certificate(
        loop.law_curve.function, loop.step_curve.function, loop.limit_sizes,
        states=along.states, fine=along.fine, outs=along.outs[:, :outs],
        body=motion.robot[..., :2], law_numbers=loop.law_numbers, step_numbers=loop.step_numbers,
        share=np.zeros(0), off=np.zeros((0, COMMAND)), law_gap=np.zeros(outs),
        step_gap=np.zeros(nz), gap=gap, aside=np.stack([motion.aside, motion.turned], axis=1),
        start=np.diag(passing.begun), disc=(0.0, 0), lower=np.zeros(loop.count),
        pairs=along.pairs, ratios=along.ratios, fast=fast, state=state, out=out,
        knots=along.knots, lags=int((LAGS + passing.begun.any()) * along.memory),
        **_known(loop, passing.inputs),
    )  # fmt: skip


def _known(loop: LawLoop, inputs: Inputs) -> dict[str, Any]:
    return {
        "queue": loop.queue, "memory": loop.memory, "acting": loop.acting, "late": loop.late,
        "push": inputs.push, "pose": inputs.pose, "reckoned": inputs.reckoned,
        "velocity": inputs.velocity, "wide": inputs.body, "command": inputs.command,
        "dead": inputs.dead,
    }  # fmt: skip
