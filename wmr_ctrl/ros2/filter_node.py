"""Lifecycle node ``wmr_filter``: reads commands, sends commands within a base's limits."""

from __future__ import annotations

from collections.abc import Collection
from functools import partial
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, Float64MultiArray

from wmr_ctrl.control.filter.gate import GateSettings
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.fields.units import limits_in_words
from wmr_ctrl.world.scenario import Scenario

from .diagnosis import MORE_PARTS, NEAR, NO_DISTANCE, TOO_FAST
from .filter_core import FilterCore
from .graph import KEPT, LATEST, SURE
from .node import SafeNode, guarded, stamp_of
from .parameters import CHANGING, FILTER, SIGHT, SPEED_SCALE
from .refusals import Received
from .sight import SightSettings, remedy
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
        self.choice("no_return")
        self.sight = SightSettings(**{name: self._stated(name) for name in SIGHT})
        core = FilterCore(scenario, settings, self.frame, self.sight, at_once=at_once)
        self._told, self._never = scenario.filter, tuple[str, ...]()
        self._remedy = remedy(scenario) if self._told.free_error is not None else ""
        core.scale = float(self.value(SPEED_SCALE))  # type: ignore[arg-type]
        return core, core.period / 4 if core.at_once else core.period

    def _stated(self, name: str) -> Any:
        """Value of a parameter, a list as a tuple."""
        value = self.value(name)
        return value if isinstance(value, (str, float)) else tuple(value)  # type: ignore[arg-type]

    def connect(self) -> None:
        """Create the topics that the documentation page lists."""
        kind = command_kind(self.stamped)
        self.out = self.create_lifecycle_publisher(kind, "cmd_vel", SURE)
        # rclpy takes what waits in this order: a command is answered with the odometry before it.
        self.listen(Odometry, "odom", self._on_odometry, LATEST)
        if self._told.changing:
            self._listen_to_limits()
        for laser, topic in enumerate(self.sight.topics):
            self.listen(LaserScan, topic, partial(self._on_scan, laser), LATEST)
        if self._told.free_error is not None and not self.sight.topics:
            self.listen(Float64MultiArray, "~/free", self._on_free, LATEST)
        self.listen(kind, "cmd_vel_in", self._on_command, LATEST)

    def _listen_to_limits(self) -> None:
        for topic in ("v_max", "v_min"):
            self.listen(Twist, f"~/{topic}", partial(self._on_limit, topic), KEPT)
        self.listen(Bool, "~/enable", self._on_enable, KEPT)
        if self.sight.speed_limit:
            try:
                from nav2_msgs.msg import SpeedLimit
            except ImportError as error:
                raise ArgumentError(
                    f"speed_limit = {self.sight.speed_limit}: this Python has no nav2_msgs. Source "
                    "a ROS 2 with nav2, or leave the parameter out."
                ) from error
            self.listen(SpeedLimit, self.sight.speed_limit, self._on_speed_limit, KEPT)

    def send(self, command: tuple[float, float]) -> None:
        """Publish velocities [m/s, rad/s]."""
        self.out.publish(twist_message(self, self.frame, self.stamped, command))

    def details(self) -> dict[str, str]:
        """Command and counters."""
        assert self.core
        v, omega = self.core.last.command
        shown = {"v": f"{v:.4f}", "omega": f"{omega:.4f}"}
        for name, intake in (
            ("command", self.core.commands), ("odometry", self.core.odometry),
            *zip(self._sources, self.core.frees, strict=False),
        ):  # fmt: skip
            shown |= {f"{name}s taken": str(intake.taken)}
            shown |= {f"{name}s {reason}": str(n) for reason, n in intake.refused.items()}
        for name, seen in zip(self.sight.topics, self.core.sights, strict=False):
            shown[f"{name} blind beams"] = str(seen.blind)
            shown[f"{name} nearest beam"] = f"{seen.nearest:.3f} m at {seen.nearest_at:.3f} rad"
        if self._sources:
            ahead, behind, left, right = self.core.free
            shown["free"] = f"{ahead:.3f} m, {behind:.3f} m, {left:.3f} rad, {right:.3f} rad"
        return shown | {"commands with other parts": str(self._with_other_parts)}

    @property
    def _sources(self) -> tuple[str, ...]:
        """Topics that supply free distances."""
        return self.sight.topics or (("free",) if self._remedy else ())

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
        causes += [self._remedy] if NEAR in flags else []
        causes += [self._why_unseen()] if NO_DISTANCE in flags else []
        return causes

    def _why_unseen(self) -> str:
        reasons = (f"{name} refused: {self._last_refused.get(name)}" for name in self._sources
                   if self._last_refused.get(name))  # fmt: skip
        return "; ".join(reasons) or f"nothing came on {', '.join(self._sources)}"

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

    @guarded
    def _on_limit(self, topic: str, message: Twist) -> None:
        assert self.core
        self.core.limit(topic, (message.linear.x, message.angular.z), self.now())

    @guarded
    def _on_enable(self, message: Bool) -> None:
        assert self.core
        self.core.limit("enable", (message.data, 0.0), self.now())

    @guarded
    def _on_speed_limit(self, message: Any) -> None:
        assert self.core
        self.core.limit("speed", (message.speed_limit, message.percentage), self.now())

    @guarded
    def _on_free(self, message: Float64MultiArray) -> None:
        assert self.core
        self.refused("free", self.core.hear_free(message.data, self.now()))

    @guarded
    def _on_scan(self, laser: int, message: LaserScan) -> None:
        assert self.core
        numbers = (
            message.angle_min, message.angle_increment, message.range_min, message.range_max,
        )  # fmt: skip
        stamp, frame, now = stamp_of(message), message.header.frame_id, self.now()
        reason = self.core.scan(laser, numbers, message.ranges, stamp, now)
        patience = self._told.free_age
        seen = Received(frame, frame, stamp, now.ros, patience, "filter.free_age of the scenario")
        self.refused(self.sight.topics[laser], seen.explained(reason))
        never, self._never = self._never, self.core.never
        if self._never and self._never != never:
            self.get_logger().warning(
                f"no beam covers {' and '.join(self._never)}: no command that way is ever sent. "
                "Add a laser, or give ignore."
            )

    def change(self, key: str, value: object) -> str:
        """Change a parameter; the share of commands that is passed on may change at any time."""
        if key != SPEED_SCALE:
            return super().change(key, value)
        assert self.core
        self.core.scale = float(value)  # type: ignore[arg-type]
        return ""
