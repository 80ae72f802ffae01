"""Lifecycle of both nodes: timers, stop and reset, last zeros, diagnostics.

Timers use the steady clock; ROS time only orders messages.  Whatever happens in a callback, it ends
in a command that may be sent.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from functools import partial, wraps
from pathlib import Path
from typing import Generic, Protocol, TypeVar, cast

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from wmr_ctrl.control.filter.gate import Gated
from wmr_ctrl.core.errors import WmrError
from wmr_ctrl.core.fields.units import limits_in_words
from wmr_ctrl.world.scenario import Scenario, load_scenario, scenario_hash

from . import diagnosis, graph
from .clocks import Clocks, Moment
from .drive_core import NO_ODOMETRY
from .graph import KEPT
from .parameters import Declared, Table

LEVELS = (DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR)


class Core(Protocol):
    """Decisions of a node: which command goes to the base, and when."""

    last: Gated
    clocks: Clocks

    def start(self) -> None:
        """Reset to the start."""

    def see(self, now: Moment) -> tuple[str, ...]:
        """Check the clocks; returns what happened to them."""

    def tick(self, now: Moment) -> Gated | None:
        """The command of a tick, if there is one."""

    def halt(self, stop: bool, now: Moment) -> Gated | None:
        """Process a message on ~/stop."""

    def reset(self) -> bool:
        """Release the latch; False if it stays."""


C = TypeVar("C", bound=Core)
R = TypeVar("R")


def guarded(callback: Callable[..., R], failed: R | None = None) -> Callable[..., R]:
    """Wrap a callback: an exception stops the base and is reported, and the node continues."""

    @wraps(callback)
    def safe(self: SafeNode[Core], *given: object) -> R:
        try:
            return callback(self, *given)
        except Exception as error:  # whatever it is, the base must be told to stop
            self.fail(f"{callback.__name__}: {error!r}")
            return cast("R", failed)

    return safe


transition = partial(guarded, failed=TransitionCallbackReturn.FAILURE)


class SafeNode(LifecycleNode, Generic[C]):
    """A lifecycle node around a core; topics, parameters and promises are in docs/howto/ros2.md."""

    topics_in: tuple[str, ...] = ()
    """Topics whose senders are reported if there are several."""

    def __init__(self, name: str, parameters: Table) -> None:
        """Declare the parameters."""
        super().__init__(name)
        self._declared = parameters
        for key, stated in parameters.items():
            self.declare(key, stated)
        self.core: C | None = None
        self.active, self._problem = False, ""
        self._held = False  # by a ~/stop that failed: zeros until ~/reset
        self._grave: tuple[str, ...] = ()
        self._passing: set[str] = set()
        self._last_refused: dict[str, str] = {}
        self.add_on_set_parameters_callback(self._on_parameters)

    def declare(self, key: str, stated: Declared) -> None:
        """Declare a parameter.  Raises WmrError if its given value is invalid."""
        shown = ParameterDescriptor(
            description=stated.text, additional_constraints=stated.constraints
        )
        if stated.range:
            low, high = stated.range
            shown.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
        try:
            self.declare_parameter(key, stated.default, shown)
        except InvalidParameterTypeException as error:
            kind = type(stated.default).__name__
            raise WmrError(
                f"the parameter {key} has a value of another type than its default "
                f"{stated.default!r} ({kind}). Numbers need a point: 1.0, not 1."
            ) from error
        except InvalidParameterValueException as error:
            raise WmrError(f"the parameter {key} is out of its range: {error}") from error

    # -- a node's own -------------------------------------------------------------------------

    def build(self, scenario: Scenario) -> tuple[C, float]:
        """Build core and period [s]; raises WmrError if the parameters cannot be satisfied."""
        raise NotImplementedError

    def connect(self) -> None:
        """Create the publisher ``out`` and the subscriptions, by `listen`."""
        raise NotImplementedError

    def send(self, command: tuple[float, float]) -> None:
        """Publish a command for the base."""
        raise NotImplementedError

    def details(self) -> dict[str, str]:
        """Further values of the diagnostics."""
        return {}

    def change(self, key: str, value: object) -> str:
        """Set a parameter of a configured node; returns the reason if it cannot change then."""
        return f"{key} can change only while the node is not configured: clean it up first"

    def causes(self, flags: Collection[str]) -> list[str]:
        """Clauses with the numbers and names behind some flags."""
        waited = {"odometry": NO_ODOMETRY in flags, "command": diagnosis.NO_COMMAND in flags}
        refused = {what: reason for what, reason in self._last_refused.items() if reason}
        return [f"{what} refused: {refused[what]}" for what in waited.keys() & refused.keys()
                if waited[what]]  # fmt: skip

    def frame_of(self, scenario: Scenario) -> str:
        """Frame of commands, and child frame of odometry: the parameter's, else the scenario's."""
        return str(self.value("base_frame")) or scenario.ros.base_frame

    # -- lifecycle ----------------------------------------------------------------------------

    def value(self, name: str) -> object:
        """Value of a parameter."""
        return self.get_parameter(name).value

    def pair(self, name: str) -> tuple[float, float]:
        """Value of a parameter of two numbers.  Raises WmrError for another length."""
        numbers = tuple(float(item) for item in self.value(name))  # type: ignore[attr-defined]
        if len(numbers) != 2:
            raise WmrError(f"{name} has {len(numbers)} numbers and must have two.")
        return numbers

    def choice(self, name: str) -> str:
        """Value of a parameter with choices.  Raises WmrError for any other value."""
        return self._declared[name].chosen(name, str(self.value(name)))

    @transition
    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the scenario and compile; log the reason if that fails."""
        path = str(self.value("scenario"))
        try:
            self._refuse_undeclared()
            if not path:
                raise WmrError(
                    "the parameter scenario is not set: the limits to keep have no default. Name a "
                    "TOML file with [limits] and [filter] or [guard], such as --ros-args -p "
                    "scenario:=mine.toml."
                )
            scenario = load_scenario(path)
            self.get_logger().info(
                f"compiling what is not in the cache; `python -m wmr_ctrl.ros2 prepare {path}`, "
                "with this node's parameters, does it beforehand"
            )
            self.core, self.period = self.build(scenario)
            self._connect()
            self._look()
        except WmrError as error:
            self.get_logger().error(" ".join(str(error).split()))
            return TransitionCallbackReturn.FAILURE
        settings, limits = scenario.filter, limits_in_words(scenario.limits.sides)
        self.get_logger().info(
            f"{Path(path).name}, hash {scenario_hash(scenario)}: filter {settings.kind}, guard "
            f"{scenario.guard.enabled}, limits {limits}, gain "
            f"{settings.gain}, push {settings.d}, period {scenario.clock.control:g} s"
        )
        return super().on_configure(state)

    def _refuse_undeclared(self) -> None:
        """Raise WmrError for a given parameter that the node does not have."""
        given = self._parameter_overrides  # rclpy has no public name for them
        own = [name for name in given if not name.startswith("qos_overrides.")]
        for name in own:
            if not self.has_parameter(name):
                known = sorted(key for key in self._parameters if "." not in key)
                raise WmrError(
                    f"{name} is not a parameter of this node. It has {', '.join(known)}."
                )

    def _look(self) -> None:
        """Raise WmrError if another node commands the base, or if a sender cannot be received."""
        end = time.monotonic() + float(self.value("discovery_time"))  # type: ignore[arg-type]
        while time.monotonic() < end:
            problem = graph.useless(self, self.out, self._heard)
            if problem:
                self._disconnect()
                raise WmrError(problem)
            time.sleep(0.05)

    def _connect(self) -> None:
        self._heard: list[Subscription] = []
        self.connect()
        self.diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.listen(Bool, "~/stop", self._on_stop, KEPT)
        self._service = self.create_service(Trigger, "~/reset", self._on_reset)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._ticks = [
            self.create_timer(self.period, self._on_tick, clock=steady),
            self.create_timer(1.0, self._on_second, clock=steady),
        ]

    def listen(
        self, kind: type, topic: str, callback: Callable[..., object], qos: QoSProfile
    ) -> None:
        """Subscribe until the node is cleaned up."""
        self._heard.append(self.create_subscription(kind, topic, callback, qos))

    @transition
    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start sending."""
        assert self.core
        self.core.start()
        self.active = True
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Send a last zero."""
        self.rest()
        return super().on_deactivate(state)

    @transition
    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Remove what configuring created."""
        self._disconnect()
        return super().on_cleanup(state)

    def _disconnect(self) -> None:
        for timer in self._ticks:
            self.destroy_timer(timer)
        for subscription in self._heard:
            self.destroy_subscription(subscription)
        self.destroy_service(self._service)
        self.destroy_publisher(self.diagnostics)
        self.destroy_lifecycle_publisher(self.out)
        self.core = None

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Send a last zero."""
        self.rest()
        return super().on_shutdown(state)

    # -- callbacks ----------------------------------------------------------------------------

    def now(self) -> Moment:
        """Read both clocks; log what happened to them."""
        clock = self.get_clock()
        now = Moment(clock.now().nanoseconds, time.monotonic_ns(), clock.ros_time_is_active)
        happened = self.core.see(now) if self.core else ()
        self._passing |= set(happened)
        if happened:
            self.get_logger().warning(f"clock: {', '.join(happened)}")
        return now

    def refused(self, what: str, reason: str) -> None:
        """Log a refused message; an empty ``reason`` marks an accepted one."""
        self._last_refused[what] = reason
        if reason:
            self.get_logger().warning(f"{what} refused: {reason}", throttle_duration_sec=1.0)

    @guarded
    def _on_stop(self, message: Bool) -> None:
        assert self.core
        held, self._held = self._held, self._held or bool(message.data)
        sent = self.core.halt(bool(message.data), self.now())
        self._held = held
        if sent:
            self.sent(sent)

    def _on_reset(self, _request: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        answer.message = "it failed: see the log"  # a service without an answer ends the node
        self._reset(answer)
        return answer

    @guarded
    def _reset(self, answer: Trigger.Response) -> None:
        assert self.core
        answer.success = self.core.reset()
        self._held = self._held and not answer.success
        answer.message = "" if answer.success else "the topic ~/stop still says true"

    @guarded
    def _on_tick(self) -> None:
        if self.active and self.core:
            sent = self.core.tick(self.now())
            if sent:
                self.sent(sent)

    def passing(self, flag: str) -> None:
        """Report a momentary flag with the next diagnostics."""
        self._passing.add(flag)

    def sent(self, gated: Gated) -> None:
        """Send the core's command, and log its grave flags when they change."""
        if not self.active:
            return
        self._passing |= diagnosis.PASSING & set(gated.flags)
        self.emit(gated.command)
        grave = diagnosis.grave(gated.flags)
        if grave != self._grave:
            self._grave = grave
            log, text = self.get_logger(), "; ".join([", ".join(grave) or "driving",
                                                      *self.causes(grave)])  # fmt: skip
            log.error(text) if diagnosis.ERRORS & set(grave) else log.info(text)
            self._on_second()

    def emit(self, command: tuple[float, float]) -> None:
        """Send a command to the base, while the node is active."""
        if self.active:
            self.send((0.0, 0.0) if self._held else command)

    def rest(self) -> None:
        """Send a last zero, and nothing after it."""
        try:
            self.emit((0.0, 0.0))
        except Exception as error:  # rclpy would drop it
            self.get_logger().fatal(f"no last zero could be sent: {error!r}")
        self.active = False

    def fail(self, text: str) -> None:
        """Stop the base after an exception and report it, even if nothing can be sent."""
        try:
            self.emit((0.0, 0.0))
        except Exception as error:  # then silence is all that is left, and the base's time-out
            text = f"{text}; nor could a zero be sent: {error!r}"
        self._problem = text
        self.get_logger().fatal(text)

    @guarded
    def _on_second(self) -> None:
        if self.core is None:
            return
        level, text = diagnosis.OK, "inactive"
        if self.active:
            level, text = self._judged()
        counts = {f"clock {name}": str(n) for name, n in self.core.clocks.counts.items()}
        details = {"flags": ", ".join(self.core.last.flags), **self.details(), **counts}
        status = DiagnosticStatus(
            level=LEVELS[level], name=self.get_fully_qualified_name(), message=text,
            values=[KeyValue(key=key, value=value) for key, value in details.items()],
        )  # fmt: skip
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self.diagnostics.publish(array)

    def _judged(self) -> tuple[int, str]:
        assert self.core
        grave = graph.useless(self, self.out, self._heard)
        if grave:
            self.get_logger().error(grave)
        topics = [self.resolve_topic_name(topic) for topic in self.topics_in]
        several = graph.doubtful(self, self.out, topics)
        flags, self._passing = {*self.core.last.flags, *self._passing}, set()
        problem, self._problem = self._problem, ""
        level, text = diagnosis.judged(flags, problem, grave, several)
        return level, "; ".join([text, *self.causes(sorted(flags))])

    def _on_parameters(self, changed: list[Parameter]) -> SetParametersResult:
        answer = SetParametersResult(successful=True)
        self._take_parameters(changed, answer)
        return answer

    @guarded
    def _take_parameters(self, changed: list[Parameter], answer: SetParametersResult) -> None:
        answer.successful, answer.reason = False, "it failed: see the log"
        reasons = [self.change(item.name, item.value) for item in changed] if self.core else []
        answer.reason = "; ".join(filter(None, reasons))
        answer.successful = not answer.reason


def stamp_of(message: object) -> int:
    """Stamp of a message's header [ns]."""
    stamp = message.header.stamp  # type: ignore[attr-defined]
    return int(stamp.sec * 1_000_000_000 + stamp.nanosec)
