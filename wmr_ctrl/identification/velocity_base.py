"""From a log of commanded and measured velocities to a scenario with [base] and [filter]."""

from dataclasses import dataclass

import numpy as np

from wmr_ctrl.world.scenario import Scenario

from .bounds import BaseIdentification, FilterBounds, Traces, loop_remarks
from .estimate import cut_of, loop_estimates, loop_score
from .fit import Tell
from .judgement import Judgement, judged
from .logs.lint import check_following
from .logs.log import COMMAND, LogError
from .logs.samples import AxisLog, Samples, axis_log, shifted_gain
from .loop_search import axis_fit
from .speed_loop import Fits, LoopFit, fitted, forecast
from .velocity_scenario import Base, scenario_of_base

LEAST_DRIVEN = 1e-3
TRAINED = 4


@dataclass(frozen=True)
class VelocityIdentification(BaseIdentification):
    """Results for a base that takes velocities.

    ``fits``: of v and omega, if driven; ``trained``: those to the first two thirds only.
    """

    bounds: FilterBounds
    fits: Fits
    trained: Fits

    def traces(self) -> Traces:
        """Measured and predicted speeds, and their deviations as in filter.d."""
        log = next(fit.log for fit in self.fits if fit is not None)
        seen, foretold, left = (np.full((len(log.t), 2), np.nan) for _ in range(3))
        for axis, (fit, trained) in enumerate(zip(self.fits, self.trained, strict=True)):
            if fit is not None and trained is not None:
                seen[:, axis], left[:, axis] = fit.log.speed, fit.deviation()
                foretold[:, axis] = np.where(log.in_fit, forecast(trained, fit.log), np.nan)
        return Traces(log.t, seen, foretold, left, self.score.held_out_from)


def of_velocities(
    name: str,
    log: Samples,
    scenario: Scenario,
    remarks: list[str],
    tell: Tell,
) -> VelocityIdentification:
    """The base of a log; raises LogError where it determines nothing."""
    axes = [axis_log(log, axis) for axis in (0, 1)]
    driven = [bool(np.std(axis.sent) > LEAST_DRIVEN) for axis in axes]
    if not any(driven):
        raise LogError(
            f"{name}: both commands are constant, so the log says nothing about the base. Change "
            "both by steps, at different times."
        )
    for axis, drives, column in zip(axes, driven, COMMAND, strict=True):
        if drives:
            check_following(name, column, *shifted_gain(axis), log.period)
    fits = same_loop(axes, driven, tell)
    judgements: list[Judgement | None] = [
        judged(fit, other, axis) if fit else None
        for axis, (fit, other) in enumerate(zip(fits, fits[::-1], strict=True))
    ]
    for fit, judgement, column in zip(fits, judgements, COMMAND, strict=True):
        if fit and judgement and not fit.at_end("gain"):
            gain = fit.values.get("gain", 1.0)
            check_following(name, column, gain, 0.0, judgement.r2, log.period)
    estimates = loop_estimates(fits, judgements, log.period)
    remarks += loop_remarks(fits, estimates, judgements)
    found = Base(log, fits, judgements, estimates)
    bounds, identified = scenario_of_base(name, scenario, found, remarks)
    cut = cut_of(log)
    first, second = (fit and trained_on(fit, cut) for fit in fits)
    trained, said = (first, second), tuple(remarks)
    score = loop_score(axes, cut, trained)
    return VelocityIdentification(
        name, estimates, bounds, said, score, identified, fits, trained,
        judgements=tuple(item for item in judgements if item),
    )  # fmt: skip


def trained_on(fit: LoopFit, cut: float) -> LoopFit:
    """The fit to what came before a time [s]."""
    log, fixed = fit.log.until(cut), dict(fit.fixed)
    return fitted(log, fit.loop, fit.names, fit.theta, TRAINED, fixed=fixed)


def same_loop(
    axes: list[AxisLog], driven: list[bool], tell: Tell
) -> tuple[LoopFit | None, LoopFit | None]:
    """Fits of both axes by one kind of loop: where they differ the one likelier for both."""
    first, second = (
        axis_fit(axis, tell) if moves else None for axis, moves in zip(axes, driven, strict=True)
    )
    if first is None or second is None or first.loop == second.loop:
        return first, second
    others = (
        (first, axis_fit(axes[1], tell, (first.loop,))),
        (axis_fit(axes[0], tell, (second.loop,)), second),
    )
    return min(others, key=lambda pair: pair[0].bic + pair[1].bic)
