"""Late poses: the pose sensor receives the pose of an earlier time.

Source: cameras and beacons need time to compute.  The pose sensor corrects its prediction by the
late pose as if it were new, like a controller that does not know the delay.
"""

from wmr_ctrl.core.fields.section import Section
from wmr_ctrl.core.signals import MEASURED_POSE, SAMPLE, Signal

from .effect import Effect, EffectRole, Scenario, adds_nothing
from .history import history, remembered
from .model.system import System, outputs, port, ports, stack

OLD_POSE = Signal("old_pose", "m, m, rad", "pose", 3)


class PoseDelay(Section, key="sensor"):
    """Age of a pose on arrival."""

    pose_delay: float = remembered("age of a pose on arrival")


def build(scenario: Scenario) -> System:
    """Sampled System: from pose to the pose some samples ago; before that, the start's."""
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
