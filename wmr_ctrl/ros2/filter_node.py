"""Lifecycle node ``wmr_filter``: reads commands, sends commands within a base's limits."""

from __future__ import annotations

from collections.abc import Collection

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry

from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.core.fields.units import limits_in_words
from wmr_ctrl.world.scenario import Scenario

from .diagnosis import MORE_PARTS, TOO_FAST
from .filter_core import FilterCore
from .graph import LATEST, SURE
from .node import SafeNode, guarded, stamp_of
from .parameters import CHANGING, FILTER, SPEED_SCALE
from .refusals import Received
from .twists import command_kind, other_parts, twist_message


class FilterNode(SafeNode[FilterCore]):
    """The node."""

    topics_in = ("cmd_vel_in",)

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("wmr_filter", FILTER | CHANGING)
        self._with_other_parts = 0

    def build(self, scenario: Scenario) -> tuple[FilterCore, float]:
        """Build the gate and its intakes."""
        settings = GateSettings(
            command_timeout=float(self.value("command_timeout")),  # type: ignore[arg-type]
            odometry_timeout=float(self.value("odometry_timeout")),  # type: ignore[arg-type]
            odometry=str(self.value("odometry")),
            rise=self.pair("rise"), fall=self.pair("fall"), excess=self.pair("excess"),
        )  # fmt: skip
        self.frame, self.stamped = self.frame_of(scenario), bool(self.value("stamped"))
        self.limits, self.settings = scenario.limits.sides, settings
        self._refuses_parts = self.choice("other_parts") == "refuse"
        at_once = self.choice("trigger") == "command"
        core = FilterCore(scenario, settings, self.frame, at_once=at_once)
        core.scale = float(self.value(SPEED_SCALE))  # type: ignore[arg-type]
        return core, core.period / 4 if core.at_once else core.period

    def connect(self) -> None:
        """Create the topics that the documentation page lists."""
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
        return shown | {"commands with other parts": str(self._with_other_parts)}

    def causes(self, flags: Collection[str]) -> list[str]:
        """Clauses on the causes of flags, with the speed that is too fast."""
        assert self.core
        causes = super().causes(flags)
        if TOO_FAST in flags:
            v, omega = self.core.measured
            more = self.settings.excess
            linear, angular = ((a - more[i], b + more[i]) for i, (a, b) in enumerate(self.limits))
            causes.append(
                f"odometry says {v:.3g} m/s and {omega:.3g} rad/s, at most "
                f"{limits_in_words((linear, angular))} ([limits] and the parameter excess)"
            )
        return causes

    @guarded
    def _on_command(self, message: TwistStamped | Twist) -> None:
        assert self.core
        twist = message.twist if self.stamped else message
        stamp, frame = (stamp_of(message), message.header.frame_id) if self.stamped else (0, "")
        now, parts = self.now(), other_parts(twist)
        if parts:
            self._with_other_parts += 1
            self.passing(MORE_PARTS)
        if parts and self._refuses_parts:
            reason = self.core.refuse_other_parts()
            self.refused("command", f"{reason}: {', '.join(parts)} (parameter other_parts)")
            return
        reason, sent = self.core.command((twist.linear.x, twist.angular.z), stamp, frame, now)
        seen = Received(
            frame, self.frame, stamp, now.ros, self.settings.command_timeout, "command_timeout"
        )
        self.refused("command", seen.explained(reason))
        if sent:
            self.sent(sent)

    @guarded
    def _on_odometry(self, message: Odometry) -> None:
        assert self.core
        turn, twist = message.pose.pose.orientation, message.twist.twist
        value, rotation = (twist.linear.x, twist.angular.z), (turn.x, turn.y, turn.z, turn.w)
        stamp, frame, now = stamp_of(message), message.child_frame_id, self.now()
        reason = self.core.measure(value, rotation, stamp, frame, now)
        seen = Received(
            frame, self.frame, stamp, now.ros, self.settings.odometry_timeout, "odometry_timeout"
        )
        self.refused("odometry", seen.explained(reason))

    def change(self, key: str, value: object) -> str:
        """Change a parameter; the share of commands that is passed on may change at any time."""
        if key != SPEED_SCALE:
            return super().change(key, value)
        assert self.core
        self.core.scale = float(value)  # type: ignore[arg-type]
        return ""
