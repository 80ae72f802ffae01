"""Certificates for `tests.corridor.fixed_point`, made from the computation of a corridor."""

import casadi as ca
import numpy as np

from tests.corridor.fixed_point import Certificate
from wmr_ctrl.theory.checks.error_coordinates import COMMAND, ROBOT
from wmr_proofs.corridor.gains import DIRECTIONS, PAIRS
from wmr_proofs.corridor.peaks import reference_gap

ROOM = 1 + 1e-4
"""Growth of the closed box, for which the inequality has some room."""


def stated(certifier, inputs):
    """The Certificate of a Certifier's closed box."""
    peaks = certifier.tube(inputs).peaks.times(ROOM)
    loop, inputs = certifier.loop, certifier._reckoned(inputs, peaks)
    nz, n, scenario = len(loop.names), len(loop.at), loop.setup.scenario
    start = np.zeros((n, 3 + COMMAND))
    start[:3, :3] = np.diag(scenario.corridor.start)
    if loop.observed:
        old = nz + COMMAND * loop.queue + loop.observed[1]
        start[old : old + COMMAND, 3:] = np.diag(certifier._before(inputs, certifier.law_rest))
    disc = inputs.pose + certifier.begun if loop.filter else 0.0
    lost = [0.0 if x.measured is None else inputs.velocity[x.measured] for x in loop.conditions]
    curves = loop.law, loop.step, loop.limits
    law_gap, step_gap, v_d = np.zeros(len(loop.remains)), np.zeros(nz), loop.step.at[3:ROBOT]
    step_gap[:2] = reference_gap(v_d, scenario.clock.plant)
    if loop.filter:
        place = COMMAND + loop.memory - loop.filter
        law_gap[place : place + 2] = reference_gap(v_d, scenario.clock.control)
    return Certificate(
        *(ca.Function("graph", [x.by], [x.output]) for x in curves), loop.law.at, loop.step.at,
        loop.remains, loop.queue, loop.memory, loop.acting, loop.steps, loop.late,
        loop.overlap.share, loop.overlap.off, inputs.push, inputs.pose, inputs.reckoned,
        inputs.velocity, inputs.body, inputs.command, inputs.dead, law_gap, step_gap, start,
        (disc, max(n - loop.acting - ROBOT, 0)), np.array(lost), certifier.gains.ratios,
        peaks.fast[: nz + DIRECTIONS + 2 * len(PAIRS)], peaks.state, peaks.law,
    )  # fmt: skip
