"""Lifecycle node ``wmr_filter``: commands in, commands out that keep a base within its limits."""

from __future__ import annotations

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import SetParametersResult
from rclpy.parameter import Parameter

from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.world.scenario import Scenario

from .filter_core import FilterCore
from .graph import LATEST, SURE
from .node import SafeNode, guarded, stamp_of
from .parameters import FILTER, SCALE, SPEED_SCALE, TRIGGERS
from .twists import command_kind, twist_message


class FilterNode(SafeNode[FilterCore]):
    """The node."""

    topics_in = ("cmd_vel_in",)

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("wmr_filter", FILTER)
        self.declare(SPEED_SCALE, SCALE, read_only=False)
        self.add_on_set_parameters_callback(self._on_parameters)

    def build(self, scenario: Scenario) -> tuple[FilterCore, float]:
        """The gate and its intakes."""
        settings = GateSettings(
            command_timeout=float(self.value("command_timeout")),  # type: ignore[arg-type]
            odometry_timeout=float(self.value("odometry_timeout")),  # type: ignore[arg-type]
            odometry=str(self.value("odometry")),
            rise=self.pair("rise"), fall=self.pair("fall"), excess=self.pair("excess"),
        )  # fmt: skip
        self.frame, self.stamped = str(self.value("base_frame")), bool(self.value("stamped"))
        trigger = str(self.value("trigger"))
        if trigger not in TRIGGERS:
            raise WmrError(f"trigger = {trigger!r} must be one of {', '.join(TRIGGERS)}.")
        core = FilterCore(scenario, settings, self.frame, at_once=trigger == "command")
        core.scale = float(self.value(SPEED_SCALE))  # type: ignore[arg-type]
        return core, core.period / 4 if core.at_once else core.period

    def connect(self) -> None:
        """Topics as in the page."""
        kind = command_kind(self.stamped)
        self.out = self.create_lifecycle_publisher(kind, "cmd_vel", SURE)
        # rclpy takes what waits in this order: a command is answered with the odometry before it.
        self.listen(Odometry, "odom", self._on_odometry, LATEST)
        self.listen(kind, "cmd_vel_in", self._on_command, LATEST)

    def send(self, command: tuple[float, float]) -> None:
        """Publish velocities [m/s, rad/s]."""
        self.out.publish(twist_message(self, self.frame, self.stamped, command))

    def details(self) -> dict[str, str]:
        """Command and counters."""
        assert self.core
        v, omega = self.core.last.command
        shown = {"v": f"{v:.4f}", "omega": f"{omega:.4f}"}
        for name, intake in (("command", self.core.commands), ("odometry", self.core.odometry)):
            shown |= {f"{name}s taken": str(intake.taken)}
            shown |= {f"{name}s {reason}": str(n) for reason, n in intake.refused.items()}
        return shown

    @guarded
    def _on_command(self, message: TwistStamped | Twist) -> None:
        assert self.core
        twist = message.twist if self.stamped else message
        stamp, frame = (stamp_of(message), message.header.frame_id) if self.stamped else (0, "")
        value = twist.linear.x, twist.angular.z
        reason, sent = self.core.command(value, stamp, frame, self.now())
        self.refused("command", reason)
        if sent:
            self.sent(sent)

    @guarded
    def _on_odometry(self, message: Odometry) -> None:
        assert self.core
        turn, twist = message.pose.pose.orientation, message.twist.twist
        value, rotation = (twist.linear.x, twist.angular.z), (turn.x, turn.y, turn.z, turn.w)
        stamp, frame = stamp_of(message), message.child_frame_id
        self.refused("odometry", self.core.measure(value, rotation, stamp, frame, self.now()))

    def _on_parameters(self, changed: list[Parameter]) -> SetParametersResult:
        answer = SetParametersResult(successful=False, reason="it failed: see the log")
        self._scale(changed, answer)
        return answer

    @guarded
    def _scale(self, changed: list[Parameter], answer: SetParametersResult) -> None:
        for item in changed:
            if item.name == SPEED_SCALE and self.core:
                self.core.scale = float(item.value)
        answer.successful, answer.reason = True, ""
