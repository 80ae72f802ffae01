"""Pose that comes late: the pose sensor is given one of some time ago.

Source: cameras and beacons take time to compute.  The pose sensor corrects its prediction by the
late pose as if it were new, which is what a controller does that does not know better.
"""

from wmr_ctrl.core.fields.section import Section
from wmr_ctrl.core.signals import MEASURED_POSE, SAMPLE, Signal

from .effect import Effect, EffectRole, Scenario, adds_nothing
from .history import history, remembered
from .model.system import System, outputs, port, ports, stack

OLD_POSE = Signal("old_pose", "m, m, rad", "pose", 3)


class PoseDelay(Section, key="sensor"):
    """Age of a pose when it comes."""

    pose_delay: float = remembered("age of a pose on arrival")


def build(scenario: Scenario) -> System:
    """Sampled System: pose to the pose some samples ago, that of the start before."""
    pose, sample = ports(MEASURED_POSE), port(SAMPLE)
    now = stack(item.sym for item in pose)
    count = round(scenario.section(PoseDelay).pose_delay / scenario.clock.control)
    seen = history(OLD_POSE, now, sample.sym == 0, count)
    return System(
        "pose_delay",
        "late pose",
        inputs=(*pose, sample),
        state=seen.state,
        update=seen.update,
        outputs=outputs(MEASURED_POSE, seen.aged[-1]),
    )


SHAPE = ("sensor.pose_delay", "clock.control")
POSE_DELAY = Effect("pose delay", EffectRole.SENSOR, PoseDelay, build, adds_nothing, shape=SHAPE)
