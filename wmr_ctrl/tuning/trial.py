"""Figures of a law on the test seeds, and which of them tuning made worse."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

WORSE = 0.05
"""Share by which a figure of the test may grow before it is told to be worse: medians of few runs
differ by some per cent anyway."""


@dataclass(frozen=True)
class TrialFigures:
    """Medians over the test seeds on one reference, for one ratio of true to believed mass.

    ``position_rms`` [m] and ``torque_change_rms`` [N m] as in a run; ``max_abs_v`` [m/s, rad/s] and
    ``lost``, runs that ended early, are the worst and the number of all; ``figures``: those of
    other packages.
    """

    reference: str
    mass: float
    position_rms: float
    torque_change_rms: float
    max_abs_v: tuple[float, float]
    lost: int
    figures: Mapping[str, float] = field(default_factory=dict)

    def worse_than(
        self, before: TrialFigures, limits: tuple[float, float]
    ) -> Iterator[tuple[str, float, float]]:
        """Name, value before and value now of each figure that is worse.

        Errors and torques that grew by more than WORSE, velocities that grew beyond ``limits``
        [m/s, rad/s], and runs lost.
        """
        errors = (
            ("position_rms", before.position_rms, self.position_rms),
            ("torque_change_rms", before.torque_change_rms, self.torque_change_rms),
        )
        yield from (item for item in errors if not item[2] <= (1 + WORSE) * item[1])
        pairs = zip(before.max_abs_v, self.max_abs_v, limits, strict=True)
        for axis, (old, new, limit) in enumerate(pairs, start=1):
            if new > max(old, limit):
                yield f"max_abs_v[{axis}]", old, new
        if self.lost > before.lost:
            yield "lost", before.lost, self.lost


@dataclass(frozen=True)
class WorseFigure:
    """A figure of the test that tuning made worse: on which reference and robot, from and to."""

    reference: str
    mass: float
    figure: str
    before: float
    after: float
