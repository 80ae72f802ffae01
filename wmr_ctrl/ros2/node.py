"""Lifecycle node ``wmr_filter``: commands in, commands out that keep a base within its limits.

The timer, ramps and time-outs are on the steady clock; ROS time only orders messages.  Whatever
happens in a callback ends in a command that the gate may send.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from functools import wraps
from pathlib import Path

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from wmr_ctrl.errors import WmrError
from wmr_ctrl.filter.gate import ODOMETRY_USES, Gated, GateSettings
from wmr_ctrl.ros2.compiled_gate import Gate
from wmr_ctrl.ros2.intake import Intake, is_rotation
from wmr_ctrl.scenario import load_scenario

LATEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
SURE = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
KEPT = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
BACK = -0.01
"""ROS time that goes back by more [s] has jumped."""
ERRORS, WARNINGS = {"too-fast", "unsound", "stopped"}, {"no-command", "no-odometry", "bounds-left"}
PARAMETERS = {
    "scenario": ("", "TOML file with [limits] and [filter]: what the promise rests on; required"),
    "command_timeout": (0.25, "s; an older command is none"),
    "odometry_timeout": (0.1, "s; older odometry is none"),
    "odometry": ("watched", f"one of {', '.join(ODOMETRY_USES)}"),
    "rise": ([1.0, 2.0], "m/s2, rad/s2; largest change of the command away from zero"),
    "fall": ([2.0, 4.0], "m/s2, rad/s2; largest change of the command towards zero"),
    "excess": ([0.05, 0.1], "m/s, rad/s beyond the limits at which odometry stops the base"),
    "base_frame": ("base_link", "child frame of odometry, frame of commands"),
    "stamped": (True, "TwistStamped commands; false: Twist"),
    "autostart": (True, "configure and activate at once; false: by a lifecycle manager"),
}
"""Read-only parameters: default and description."""


def guarded(callback: Callable[..., object]) -> Callable[..., object]:
    """Let a callback's exception stop the base and be told, not end the node."""

    @wraps(callback)
    def safe(self: FilterNode, *given: object) -> object:
        try:
            return callback(self, *given)
        except Exception as error:  # whatever it is, the base must be told to stop
            self.fail(f"{callback.__name__}: {error!r}")
            return None

    return safe


class FilterNode(LifecycleNode):
    """The node; its topics, parameters and promises are in docs/howto/ros2.md."""

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("wmr_filter")
        for name, (value, text) in PARAMETERS.items():
            fixed = ParameterDescriptor(description=text, read_only=True)
            self.declare_parameter(name, value, fixed)
        share = ParameterDescriptor(
            description="share of each command that is passed on",
            floating_point_range=[FloatingPointRange(from_value=0.0, to_value=1.0)],
        )
        self.declare_parameter("speed_scale", 1.0, share)
        self.add_on_set_parameters_callback(self._on_parameters)
        self.gate: Gate | None = None
        self.active, self.stop, self.reset, self.scale = False, False, False, 1.0
        self.last = Gated((0.0, 0.0), ())
        self._told: tuple[str, ...] | None = None
        self._problem = ""

    # -- lifecycle ----------------------------------------------------------------------------

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the scenario and compile the gate; a sentence in the log where that fails."""
        try:
            self._configure()
        except WmrError as error:
            self.get_logger().error(" ".join(str(error).split()))
            return TransitionCallbackReturn.FAILURE
        return super().on_configure(state)

    def _value(self, name: str) -> object:
        return self.get_parameter(name).value

    def _configure(self) -> None:
        path = str(self._value("scenario"))
        if not path:
            raise WmrError(
                "the parameter scenario is not set: the limits that are to be kept have no "
                "default. Name a TOML file with [limits] and [filter], such as "
                "--ros-args -p scenario:=mine.toml."
            )
        scenario = load_scenario(path)
        settings = GateSettings(
            command_timeout=float(self._value("command_timeout")),  # type: ignore[arg-type]
            odometry_timeout=float(self._value("odometry_timeout")),  # type: ignore[arg-type]
            odometry=str(self._value("odometry")),
            **{name: tuple(self._value(name)) for name in ("rise", "fall", "excess")},  # type: ignore[arg-type]
        )
        self.gate = Gate(scenario, settings)
        frame, self.stamped = str(self._value("base_frame")), bool(self._value("stamped"))
        self.base_frame = frame
        self.commands = Intake(settings.command_timeout, frame)
        self.odometry = Intake(settings.odometry_timeout, frame)
        kind = TwistStamped if self.stamped else Twist
        self.out = self.create_lifecycle_publisher(kind, "cmd_vel", SURE)
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_subscription(kind, "cmd_vel_in", self._on_command, LATEST)
        self.create_subscription(Odometry, "odom", self._on_odometry, LATEST)
        self.create_subscription(Bool, "~/stop", self._on_stop, KEPT)
        self.create_service(Trigger, "~/reset", self._on_reset)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.tick = self.create_timer(self.gate.period, self._on_tick, clock=steady)
        self.second = self.create_timer(1.0, self._on_second, clock=steady)
        self._now = self._before = 0.0
        (v, omega), d = scenario.limits.v_u1, scenario.filter.d
        self.get_logger().info(
            f"{Path(path).name}: filter {scenario.filter.kind}, limits {v:g} m/s and {omega:g} "
            f"rad/s, gain {scenario.filter.gain}, push {d}, period {self.gate.period:g} s"
        )

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Send from now on: zeros until there is a command."""
        assert self.gate
        self.gate.start()
        self.commands.forget()
        self.odometry.forget()
        self._before, self.active = 0.0, True
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Send a last zero."""
        self._send(0.0, 0.0)
        self.active = False
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Take down what configuring made."""
        self._take_down()
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Send a last zero."""
        if self.active:
            self._send(0.0, 0.0)
        self.active = False
        return super().on_shutdown(state)

    def _take_down(self) -> None:
        for timer in (self.tick, self.second):
            self.destroy_timer(timer)
        for subscription in list(self.subscriptions):
            if "parameter" not in subscription.topic_name:
                self.destroy_subscription(subscription)
        self.gate = None

    # -- what comes in ------------------------------------------------------------------------

    def _ros_time(self) -> float:
        """ROS time [s]; after a jump back what came before counts no more."""
        now = self.get_clock().now().nanoseconds * 1e-9
        if now - self._now < BACK:
            self.get_logger().warning("ROS time went back: commands and odometry begin anew.")
            self.commands.forget()
            self.odometry.forget()
        self._now = now
        return now

    @guarded
    def _on_command(self, message: TwistStamped | Twist) -> None:
        header, twist = (message.header, message.twist) if self.stamped else (None, message)
        stamp = _seconds(header.stamp) if header else 0.0
        frame = header.frame_id if header else ""
        value = twist.linear.x, twist.angular.z
        self._count("command", self.commands.take(value, stamp, frame, self._ros_time(), _steady()))

    @guarded
    def _on_odometry(self, message: Odometry) -> None:
        turn = message.pose.pose.orientation
        twist, stamp = message.twist.twist, _seconds(message.header.stamp)
        value = twist.linear.x, twist.angular.z
        if not is_rotation(turn.x, turn.y, turn.z, turn.w):
            value = float("nan"), float("nan")
        frame, now = message.child_frame_id, self._ros_time()
        self._count("odometry", self.odometry.take(value, stamp, frame, now, _steady()))

    def _count(self, what: str, reason: str) -> None:
        if reason:
            self.get_logger().warning(f"{what} refused: {reason}", throttle_duration_sec=1.0)

    @guarded
    def _on_stop(self, message: Bool) -> None:
        self.stop = bool(message.data)
        if self.stop:
            self._on_tick()

    @guarded
    def _on_reset(self, _request: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        self.reset = True
        answer.success, answer.message = not self.stop, ""
        if self.stop:
            answer.message = "the topic ~/stop still says true"
        return answer

    def _on_parameters(self, changed: list[Parameter]) -> SetParametersResult:
        for item in changed:
            if item.name == "speed_scale":
                self.scale = float(item.value)
        return SetParametersResult(successful=True)

    # -- what goes out ------------------------------------------------------------------------

    @guarded
    def _on_tick(self) -> None:
        if not self.active or self.gate is None:
            return
        now = _steady()
        elapsed = now - self._before if self._before else 0.0
        self._before = now
        v, omega = self.commands.value
        self.last = self.gate.step(
            (self.scale * v, self.scale * omega), self.commands.age(now),
            self.odometry.value, self.odometry.age(now), elapsed, stop=self.stop, reset=self.reset,
        )  # fmt: skip
        self.reset, self._problem = False, ""
        self._send(*self.last.command)
        grave = tuple(flag for flag in self.last.flags if flag in ERRORS | WARNINGS)
        if grave != self._told:
            self._told = grave
            log = self.get_logger()
            text = ", ".join(grave) or "driving"
            log.error(text) if ERRORS & set(grave) else log.info(text)
            self._on_second()

    def _send(self, v: float, omega: float) -> None:
        if not self.active:
            return
        message = TwistStamped() if self.stamped else Twist()
        twist = message.twist if self.stamped else message
        twist.linear.x, twist.angular.z = v, omega
        if self.stamped:
            message.header.stamp = self.get_clock().now().to_msg()
            message.header.frame_id = self.base_frame
        self.out.publish(message)

    def fail(self, text: str) -> None:
        """Stop the base after an exception, and tell it."""
        self._problem = text
        self._send(0.0, 0.0)
        self.get_logger().fatal(text)

    @guarded
    def _on_second(self) -> None:
        rivals = self.count_publishers("cmd_vel") - 1
        flags, values = set(self.last.flags), [f"{part:.4f}" for part in self.last.command]
        level, text = DiagnosticStatus.OK, "driving"
        if not self.active:
            text = "inactive"
        elif self._problem or rivals > 0 or flags & ERRORS:
            level = DiagnosticStatus.ERROR
            rival = (
                f"{rivals} other publishers on cmd_vel: the promise is void" if rivals > 0 else ""
            )
            text = self._problem or rival or ", ".join(sorted(flags & ERRORS))
            if rivals > 0:
                self.get_logger().error(rival)
        elif flags & WARNINGS:
            level, text = DiagnosticStatus.WARN, ", ".join(sorted(flags & WARNINGS))
        details = {"v": values[0], "omega": values[1], "flags": ", ".join(self.last.flags)}
        for name, intake in (("command", self.commands), ("odometry", self.odometry)):
            details |= {f"{name}s taken": str(intake.taken)}
            details |= {f"{name}s {reason}": str(n) for reason, n in intake.refused.items()}
        status = DiagnosticStatus(
            level=level, name=self.get_fully_qualified_name(), message=text,
            values=[KeyValue(key=key, value=value) for key, value in details.items()],
        )  # fmt: skip
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self.diagnostics.publish(array)


def _steady() -> float:
    return time.monotonic()


def _seconds(stamp: object) -> float:
    return stamp.sec + stamp.nanosec * 1e-9  # type: ignore[attr-defined]


def _interrupt(_number: int, _frame: object) -> None:
    raise KeyboardInterrupt


def spin(arguments: list[str]) -> int:
    """Run the node until it is interrupted; 0, or 2 where it cannot be configured at once."""
    # ROS' own handlers end the context before a last zero can be sent.
    rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _interrupt)
    node, code = FilterNode(), 0
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        if node.get_parameter("autostart").value:
            configured = node.trigger_configure() == TransitionCallbackReturn.SUCCESS
            code = 0 if configured else 2
            if configured:
                node.trigger_activate()
        while code == 0 and rclpy.ok():
            executor.spin_once(timeout_sec=0.5)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        if node.active and rclpy.ok():
            node.trigger_deactivate()
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
    return code
