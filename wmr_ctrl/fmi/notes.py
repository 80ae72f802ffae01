"""What the documentation inside an FMU says about its timing and use."""

from __future__ import annotations

from wmr_ctrl.fmi.model import FmuModel
from wmr_ctrl.laws import LAWS

_COMMON = (
    "All quantities are in SI units. theta is 0 along +Y and the robot drives along "
    "(-sin theta, cos theta); psi = theta + pi/2 is the usual heading.",
    "The folder extra/org.wmr-ctrl holds the scenario, a reference result and, for single blocks, "
    "the serialised CasADi function.",
)
_KIND = {
    "continuous": (
        "Co-simulation takes Runge-Kutta steps of clock.plant seconds with inputs held; a rest "
        "shorter than that is one further step. robot.m, robot.I and robot.mu may be changed "
        "between steps.",
    ),
    "sampled": (
        "The model is evaluated at the start of each step that begins at, or passes, a multiple of "
        "clock.control seconds, with the inputs set before that step, and holds its outputs until "
        "the next such time. After initialisation the outputs are those of the first sample, and "
        "no memory has moved.",
        "The reference gives its values at the time that was reached.",
        "Step the controller with what reference and plant gave last, then the plant with its "
        "torques, then the reference: one sample of delay destroys a model-based law at 10 ms. For "
        "masters that step all parts at once, set clock.parallel to 1 in the controller.",
    ),
    "loop": (
        "One control sample is run at the start of each control period. Outputs are those of that "
        "sample; pose and velocity are those of the last control instant that was reached. seed "
        "picks the noise, as --seed does. disturbance.push pushes each axis on in its direction of "
        "motion, through robot.r and robot.l. The drives' delay, and whether they have a lag, are "
        "fixed: the controller is built for them.",
    ),
}


_LAW = (
    "The folder extra/org.wmr-ctrl/code holds the law in plain C; its interface.xml says how to "
    "call it without FMI's functions.",
)


def notes_of(model: FmuModel) -> tuple[str, ...]:
    """Paragraphs of the documentation page."""
    return (*_KIND[model.kind], *(_LAW if model.what in LAWS else ()), *_COMMON)
