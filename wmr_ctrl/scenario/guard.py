"""What the velocity guard assumes about robot and disturbances, and how it is set."""

from __future__ import annotations

from wmr_ctrl.errors import ScenarioError
from wmr_ctrl.fields.section import Section, quantity

MAPS = ("linear-first", "rotation-first")


class Guard(Section, key="guard"):
    """Settings of the guard that keeps |v1|, |omega| within limits.v_u1 (linear, angular).

    What is left out follows from the rest of the scenario: masses from what the laws believe of the
    robot, dbar from the noise, nbar from the sensor, delay and lag from the drives, alpha from the
    control period, brake from the torque limit.  Whether the settings can be met is checked where
    the guard is built, and there a stated bound that the scenario itself breaks is refused, unless
    ``trust`` says that it is meant.  A robot that is not what is believed is run, without promise.
    """

    enabled: bool = quantity(False, unit="1", doc="whether the guard filters the law's force")
    trust: bool = quantity(
        False, unit="1", doc="whether stated bounds count though the scenario breaks them"
    )
    map: str = quantity(
        "linear-first",
        unit="1",
        doc="which axis the wheels serve first behind the guard",
        options=MAPS,
    )
    mass_margin: float = quantity(
        0.1, unit="1", doc="share by which M_min, M_max go beyond the model's", minimum=0, below=1
    )
    M_min: tuple[float, float] | None = quantity(
        None, unit="kg, kg.m2", doc="smallest mass and inertia possible", above=0, size=2
    )
    M_max: tuple[float, float] | None = quantity(
        None, unit="kg, kg.m2", doc="largest mass and inertia possible", above=0, size=2
    )
    dbar: tuple[float, float] | None = quantity(
        None, unit="N, N.m", doc="bound of the disturbance force", minimum=0, size=2
    )
    d_model: tuple[float, float] = quantity(
        (0.0, 0.0), unit="N, N.m", doc="what a derived dbar gets beside the noise", minimum=0
    )
    nbar: tuple[float, float] | None = quantity(
        None, unit="m/s, rad/s", doc="bound of the velocity's error", minimum=0, size=2
    )
    delay: tuple[float, float] | None = quantity(
        None,
        unit="s",
        doc="bounds of a command's delay, which may vary",
        minimum=0,
        maximum=10,
        size=2,
        usual=(0, 2),
    )
    lag: tuple[float, float] | None = quantity(
        None,
        unit="s",
        doc="bounds of the drives' time constant, which may vary; the same twice: constant",
        minimum=0,
        size=2,
        usual=(0, 2),
    )
    alpha: float | None = quantity(
        None, unit="1/s", doc="rate at which the limit may be approached, at most 1/T", above=0
    )
    brake: tuple[float, float] | None = quantity(
        None, unit="N, N.m", doc="largest force with which the guard brakes", minimum=0, size=2
    )
    brake_share: float = quantity(
        0.5, unit="1", doc="share of spare wheel torque for linear braking", minimum=0, maximum=1
    )
    f_min: tuple[float, float] = quantity(
        (0.0, 0.0), unit="N, N.m", doc="friction that is sure to act above f_speed", minimum=0
    )
    f_speed: tuple[float, float] = quantity(
        (0.0, 0.0), unit="m/s, rad/s", doc="speed above which f_min acts", minimum=0
    )

    def relate(self) -> None:
        """Bounds are the right way round: M_min <= M_max where both are there, delay and lag."""
        for name, what in (("delay", "a command's delay"), ("lag", "the time constant")):
            first, second = getattr(self, name) or (0.0, 0.0)
            if first > second:
                raise ScenarioError(
                    f"guard.{name} = [{first!r}, {second!r}] is the wrong way round: {what} lies "
                    f"between the first and the second. Write [{second!r}, {first!r}]."
                )
        if self.M_min is None or self.M_max is None:
            return
        for axis, (low, high) in enumerate(zip(self.M_min, self.M_max, strict=True), 1):
            if low > high:
                raise ScenarioError(
                    f"guard.M_min[{axis}] = {low!r} must be at most guard.M_max[{axis}] = "
                    f"{high!r}: they bound the same mass. Give both, or leave both out."
                )
