"""Periods of control and plant, and the length of a run."""

from __future__ import annotations

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.section import Section, quantity
from wmr_ctrl.fields.values import multiple

MOST_SAMPLES = 10_000_000
MOST_SUBSTEPS = 100_000


class Clock(Section, key="clock"):
    """Control period (zero-order hold), plant step (RK4) and duration of a run."""

    control: float = quantity(
        0.01, unit="s", doc="period of the control law", minimum=1e-9, usual=(1e-4, 1)
    )
    plant: float = quantity(
        0.001, unit="s", doc="step of the plant's integration", minimum=1e-9, usual=(1e-6, 0.1)
    )
    duration: float = quantity(80.0, unit="s", doc="length of a run", minimum=1e-9)

    @property
    def substeps(self) -> int:
        """Plant steps in one control period."""
        return round(self.control / self.plant)

    @property
    def samples(self) -> int:
        """Control periods in a run."""
        return round(self.duration / self.control)

    def relate(self) -> None:
        """The control period is a whole number of plant steps, the run one of control periods."""
        _whole("clock.control", self.control, "clock.plant", self.plant, MOST_SUBSTEPS)
        _whole("clock.duration", self.duration, "clock.control", self.control, MOST_SAMPLES)


def _whole(name: str, value: float, unit_name: str, period: float, most: int) -> None:
    count = multiple(value, period)
    ratio = value / period
    if count == 0 or (count is None and ratio < most):
        near = max(1, round(ratio)) * period
        raise ScenarioError(
            f"{name} = {value!r} s must be a whole multiple of {unit_name} = {period!r} s, not "
            f"{ratio:.9g} times it. The nearest is {near:.9g} s."
        )
    if count is None or count > most:
        raise ScenarioError(
            f"{name} = {value!r} s is {ratio:.3g} times {unit_name} = {period!r} s; at most "
            f"{most:.0e} are possible. Shorten {name} or lengthen {unit_name}."
        )
