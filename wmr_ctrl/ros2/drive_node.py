"""Lifecycle node ``wmr_drive``: reads odometry, sends the commands of a control law."""

from __future__ import annotations

from nav_msgs.msg import Odometry, Path
from std_msgs.msg import Float64MultiArray

from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.control.laws.given import law_name
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.world.scenario import Scenario

from .drive_core import DriveCore, DriveSettings
from .graph import KEPT, LATEST, SURE
from .node import SafeNode, guarded, stamp_of
from .parameters import DRIVE
from .refusals import Received
from .twists import command_kind, twist_message

SIDES = ("right", "left")
"""Order of the wheels in a law's torques."""


class DriveNode(SafeNode[DriveCore]):
    """The node."""

    topics_in = ("odom",)

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("wmr_drive", DRIVE)

    def build(self, scenario: Scenario) -> tuple[DriveCore, float]:
        """Build law, reference and gate."""
        law = str(self.value("law"))
        if not law:
            raise WmrError(
                "the parameter law is not set: which law drives the base has no default. Name "
                "one, such as --ros-args -p law:=kanayama; `wmr-ctrl laws` lists them."
            )
        self.wheels = [str(name) for name in self.value("wheels")]  # type: ignore[attr-defined]
        if sorted(self.wheels) != sorted(SIDES):
            raise WmrError(f"wheels = {self.wheels} must name left and right, each once.")
        if scenario.filter.free_error is not None:
            raise WmrError(
                "filter.free_error: this node hears no distances, so that the base would never "
                "move. Leave it out, and let the commands pass wmr_filter with it."
            )
        late = float(self.value("odometry_timeout"))  # type: ignore[arg-type]
        gate = GateSettings(
            command_timeout=late, odometry_timeout=late, odometry="required",
            rise=self.pair("rise"), fall=self.pair("fall"), excess=self.pair("excess"),
        )  # fmt: skip
        self.frame, self.stamped = self.frame_of(scenario), bool(self.value("stamped"))
        settings = DriveSettings(
            gate=gate, odometry_frame=str(self.value("odometry_frame")), base_frame=self.frame,
            jump=self.pair("jump"), path=self.choice("reference") == "path",
        )  # fmt: skip
        setup = settle(scenario, law_name(law))
        if not (setup.takes_velocity or scenario.guard.enabled):
            self.get_logger().warning(
                "guard.enabled = false: no speed limit is guaranteed for these torques."
            )
        return DriveCore(setup, settings), scenario.clock.control

    def connect(self) -> None:
        """Create the topics that the documentation page lists."""
        assert self.core
        self.twists = self.core.setup.takes_velocity
        kind = command_kind(self.stamped) if self.twists else Float64MultiArray
        topic = "cmd_vel" if self.twists else "effort_commands"
        self.out = self.create_lifecycle_publisher(kind, topic, SURE)
        self.listen(Odometry, "odom", self._on_odometry, LATEST)
        if self.core.settings.path:
            self.listen(Path, "path", self._on_path, KEPT)

    def send(self, command: tuple[float, float]) -> None:
        """Publish velocities [m/s, rad/s], or torques [N m] in the order of ``wheels``."""
        if self.twists:
            simulated = self.get_clock().ros_time_is_active
            sample = self.core.measured.struct.stamp if self.core and simulated else 0
            self.out.publish(twist_message(self, self.frame, self.stamped, command, sample))
            return
        torques = dict(zip(SIDES, command, strict=True))
        self.out.publish(Float64MultiArray(data=[torques[name] for name in self.wheels]))

    def details(self) -> dict[str, str]:
        """Command, tracking error and counters."""
        assert self.core
        names = ("v", "omega") if self.twists else ("tau_right", "tau_left")
        shown = {
            name: f"{value:.4f}" for name, value in zip(names, self.core.last.command, strict=True)
        }
        shown |= {f"e{i + 1}": f"{part:.4f}" for i, part in enumerate(self.core.e)}
        shown |= {"odometry taken": str(self.core.measured.taken)}
        shown |= {f"odometry {why}": str(n) for why, n in self.core.measured.refused.items()}
        shown |= {f"times {why}": str(n) for why, n in self.core.counts.items() if n}
        shown |= {"oldest odometry [ms]": f"{1e3 * self.core.oldest:.2f}"}
        self.core.oldest = 0.0
        return shown | ({"path": self.core.problem} if self.core.problem else {})

    @guarded
    def _on_odometry(self, message: Odometry) -> None:
        if not (self.core and self.active):
            return
        pose, twist = message.pose.pose, message.twist.twist
        place, turn = pose.position, pose.orientation
        where, moved = (place.x, place.y), (twist.linear.x, twist.angular.z)
        numbers = (*where, turn.x, turn.y, turn.z, turn.w, *moved)
        stamp, frame, child = stamp_of(message), message.header.frame_id, message.child_frame_id
        now, settings = self.now(), self.core.settings
        reason, sent = self.core.odometry(numbers, stamp, frame, child, now)
        seen = Received(
            f"{frame} -> {child}", f"{settings.odometry_frame} -> {settings.base_frame}", stamp,
            now.ros, settings.gate.odometry_timeout, "odometry_timeout",
            "odometry_frame or base_frame",
        )  # fmt: skip
        self.refused("odometry", seen.explained(reason))
        if sent:
            self.sent(sent)

    @guarded
    def _on_path(self, message: Path) -> None:
        if self.core and self.active:
            places = (pose.pose.position for pose in message.poses)
            points = [(place.x, place.y) for place in places]
            self.refused("path", self.core.follow(points, message.header.frame_id))
