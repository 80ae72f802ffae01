"""Decisions of ``wmr_filter``: from messages and ticks to the command for the base.

They are C (`fmu/ros2/filter_core.c`), which the node in C uses, too.  Nothing here depends on ROS:
the node passes on what arrived and when.
"""

import ctypes
from array import array
from collections.abc import Sequence
from ctypes import byref, c_double, c_int64
from functools import cache
from pathlib import Path

from jinja2 import Environment

from wmr_ctrl.codegen.dialect import HEADER, SCALAR
from wmr_ctrl.codegen.kernels import controller_kernel, way_kernel
from wmr_ctrl.codegen.package import text_engine
from wmr_ctrl.codegen.resources import c_texts
from wmr_ctrl.codegen.source import plain_sources
from wmr_ctrl.codegen.toolchain import build_library
from wmr_ctrl.control.filter.channels import NEAR_BY
from wmr_ctrl.control.filter.gate import GATE_FLAGS, Gated, GateSettings, gate_system
from wmr_ctrl.results.bag_topics import UNIT
from wmr_ctrl.world.scenario import Scenario

from .clocks import Clocks, Moment, longest_pause, named_happenings
from .compiled_system import PAIR, VISIBLE
from .intake import IntakeCounts, fits
from .native import (
    NODE_CORE,
    BeamsStruct,
    ClocksStruct,
    IntakeStruct,
    SightStruct,
    functions_of,
    in_ns,
    node_functions,
    reason_words,
)
from .sight import MOST, SightSettings, windows

_RETURNS: dict[str, type | None] = {
    **dict.fromkeys((
        "size", "see", "command", "odometry", "due", "overdue", "reset", "free", "scan", "never",
    ), c_int64),
    **dict.fromkeys(("make", "start", "tick", "limit")),
}  # fmt: skip
FILTER_CORE = (*NODE_CORE, "filter_core.h", "filter_core.c", "scan_core.h", "scan_core.c")
LIMIT_TOPICS = ("v_max", "v_min", "enable", "speed")
"""Messages on limits, in the order of the C enumeration."""
SIDES = ("ahead", "behind")
"""Sides in the order of their bits in C."""


@cache
def node_templates() -> Environment:
    """Texts of the node's files beside its hand-written C."""
    engine = text_engine(Path(__file__).parent / "templates")
    engine.filters |= {"quoted": _quoted, "number": SCALAR.number, "ns": in_ns}
    return engine


def _quoted(text: str) -> str:
    """A text as a C string literal, with octal escapes for all but plain ASCII."""
    plain = "".join(
        chr(byte) if 32 <= byte < 127 and byte not in b'"\\?' else f"\\{byte:03o}"
        for byte in text.encode()
    )
    return f'"{plain}"'


def core_files(
    scenario: Scenario, settings: GateSettings, sight: SightSettings | None = None
) -> dict[str, str]:
    """C of a filter's decisions: file name to text.

    Raises ArgumentError, and ScenarioError if no filter is set or its limit cannot be kept.
    """
    seen = sight or SightSettings()
    seen.check(scenario)
    gate, period = gate_system(scenario, settings), scenario.clock.control
    kernels = [controller_kernel(gate, "gate"), *([way_kernel()] if seen.topics else [])]
    numbers = node_templates().get_template("gate_numbers.h.j2")
    longest = longest_pause(settings.command_timeout, period)
    return {
        **plain_sources(kernels, "gate"),
        "gate_numbers.h": numbers.render(
            gate=gate,
            settings=settings,
            period=period,
            longest=longest,
            unit=UNIT,
            sight=seen,
            scenario=scenario,
            near=NEAR_BY,
            windows=windows(scenario) if seen.topics else {},
        ),
        **c_texts(HEADER),
        **c_texts(*FILTER_CORE, folder="ros2"),
    }


class _Core(ctypes.Structure):
    """``wmr_filter_core`` without its last members: the gate's state, and the points of scans."""

    _fields_ = [
        ("commands", IntakeStruct),
        ("odometry", IntakeStruct),
        ("frees", IntakeStruct * MOST),
        ("clocks", ClocksStruct),
        *((name, c_int64) for name in (
            "stop", "reset", "before", "answered", "stamp", "flags")),
        ("limited", c_int64 * len(LIMIT_TOPICS)),
        ("command", c_double * 2),
        ("measured", c_double * 2),
        ("scale", c_double),
        ("sent", c_double * 2),
        ("limits", c_double * 2 * len(LIMIT_TOPICS)),
        ("told", c_double * 4),
        ("free", c_double * 4),
        ("sights", SightStruct * MOST),
    ]  # fmt: skip


class FilterCore:
    """Gate, intakes and clocks of a filter node; ``period`` [s], ``last`` command sent.

    ``commands`` and ``odometry`` count messages.  ``at_once``: a command that arrives when one is
    due is passed on immediately, and the timer only watches; else the timer sends.
    """

    def __init__(
        self,
        scenario: Scenario,
        settings: GateSettings,
        frame: str = "",
        sight: SightSettings | None = None,
        *,
        at_once: bool = False,
    ) -> None:
        """Compile the gate; ``frame`` is that of the base.  Raises ScenarioError, CompilerError."""
        path = build_library(core_files(scenario, settings, sight), name="filter", flags=VISIBLE)
        self._c = functions_of(ctypes.CDLL(str(path)), _RETURNS, "wmr_filter_core_")
        size = self._c["size"]()
        self._memory = (c_double * (size // ctypes.sizeof(c_double)))()
        self._core = _Core.from_buffer(self._memory)
        self.period, self.at_once, self._frame = scenario.clock.control, at_once, frame.encode()
        self._call("make")
        self.commands, self.odometry = map(IntakeCounts, (self._core.commands, self._core.odometry))
        self.frees = [*map(IntakeCounts, self._core.frees)]
        self.sights: list[SightStruct] = [*self._core.sights]
        self.clocks = Clocks(0, self._core.clocks)
        self.last = Gated(PAIR, ())

    def _call(self, name: str, *given: object) -> int:
        return self._c[name](byref(self._core), *given)

    @property
    def scale(self) -> float:
        """Share of each command that is passed on (speed scale)."""
        return float(self._core.scale)

    @scale.setter
    def scale(self, share: float) -> None:
        """Set the share of each command that is passed on."""
        self._core.scale = share

    @property
    def measured(self) -> tuple[float, float]:
        """Velocity of the newest accepted odometry [m/s, rad/s]."""
        return self._core.measured[0], self._core.measured[1]

    def refuse_other_parts(self) -> str:
        """Count a command refused for its other components; returns the reason."""
        (reason,) = (k for k, word in enumerate(reason_words()) if word.startswith("other parts"))
        node_functions()["intake_refuse"](byref(self._core.commands), c_int64(reason))
        return reason_words()[reason]

    def start(self) -> None:
        """Reset: no command, no odometry, nothing latched."""
        self._call("start")

    def see(self, now: Moment) -> tuple[str, ...]:
        """Check the clocks; returns what happened to them, for the report."""
        return named_happenings(self._call("see", byref(now.struct)))

    def command(
        self, velocity: Sequence[float], stamp: int, frame: str, now: Moment
    ) -> tuple[str, Gated | None]:
        """Take a command; returns the reason if it is refused ("" if not), and the command sent, if
        any.

        ``velocity``: v [m/s], omega [rad/s]; ``stamp`` [ns] is its own, 0 if it has none.
        """
        pair, framed = (c_double * 2)(*velocity), c_int64(fits(self._frame, frame, False))
        reason = self._call("command", pair, framed, c_int64(stamp), byref(now.struct))
        answers = (
            self.at_once and not reason and self._call("due", c_int64(stamp), byref(now.struct))
        )
        return reason_words()[reason], self._send(True, stamp, now) if answers else None

    def measure(
        self,
        velocity: Sequence[float],
        quaternion: Sequence[float],
        stamp: int,
        frame: str,
        now: Moment,
    ) -> str:
        """Take odometry; returns the reason if it is refused, else "". ``quaternion``: x, y,
        z, w.
        """
        pair, turn = (c_double * 2)(*velocity), (c_double * 4)(*quaternion)
        framed = c_int64(fits(self._frame, frame, False))
        reason = self._call("odometry", pair, turn, framed, c_int64(stamp), byref(now.struct))
        return reason_words()[reason]

    def limit(self, topic: str, numbers: tuple[float, float], now: Moment) -> None:
        """Take a message of one of LIMIT_TOPICS: limits of v and omega, or its one number and 0.

        For "speed" a 1 follows a percentage; 0 m/s is no limit.
        """
        place, pair = LIMIT_TOPICS.index(topic), (c_double * 2)(*numbers)
        self._call("limit", c_int64(place), pair, byref(now.struct))

    def hear_free(self, ways: Sequence[float], now: Moment) -> str:
        """Take free distances ahead, behind [m], left and right [rad]; returns why refused, else
        "".
        """
        numbers = (c_double * len(ways))(*ways)
        return reason_words()[self._call("free", numbers, c_int64(len(ways)), byref(now.struct))]

    def scan(
        self,
        laser: int,
        numbers: tuple[float, float, float, float],
        ranges: Sequence[float],
        stamp: int,
        now: Moment,
    ) -> str:
        """Take a scan; returns the reason if it is refused, else "".

        ``numbers``: angle of the first beam and between two [rad], least and largest range [m].
        """
        held = array("f", ranges)
        beams = BeamsStruct(*numbers, len(held), held.buffer_info()[0])
        given = c_int64(laser), byref(beams), c_int64(stamp), byref(now.struct)
        return reason_words()[self._call("scan", *given)]

    @property
    def free(self) -> tuple[float, ...]:
        """Free distances last given to the gate: ahead, behind [m], left, right [rad]."""
        return tuple(self._core.free)

    @property
    def never(self) -> tuple[str, ...]:
        """Sides that are never free, since no beam covers them."""
        bits = self._call("never")
        return tuple(side for k, side in enumerate(SIDES) if bits >> k & 1)

    def halt(self, stop: bool, now: Moment) -> Gated | None:
        """Process a message on ~/stop; true stops immediately."""
        self._core.stop = stop
        return self._send(False, 0, now) if stop else None

    def reset(self) -> bool:
        """Release the latch of a stop, or of a base that was too fast, at the next tick.

        Returns False while ~/stop is true, which keeps the base stopped.
        """
        return bool(self._call("reset"))

    def tick(self, now: Moment) -> Gated | None:
        """The command for the base if the timer has to send one."""
        if self.at_once and not self._call("overdue", byref(now.struct)):
            return None
        return self._send(False, 0, now)

    def _send(self, answered: bool, stamp: int, now: Moment) -> Gated:
        self._call("tick", c_int64(answered), c_int64(stamp), byref(now.struct))
        bits = int(self._core.flags)
        names = tuple(name for bit, name in GATE_FLAGS.items() if bits & bit)
        self.last = Gated((self._core.sent[0], self._core.sent[1]), names)
        return self.last
