"""The nodes' decisions in C (`fmu/ros2`): its structs, its library, its sources."""

import ctypes
from collections.abc import Mapping
from functools import cache
from typing import TypeAlias

from wmr_ctrl.codegen.resources import c_texts
from wmr_ctrl.codegen.toolchain import build_library

from .compiled_system import VISIBLE

NS = 1e-9
"""Second of a nanosecond."""
HAPPENINGS = ("time-back", "time-forth", "frozen")
"""Happenings of time, in the order of their bits."""
REASONS = 11
"""Number of words of ``wmr_reason``."""
NODE_CORE = ("node_core.h", "node_core.c")


def in_ns(seconds: float) -> int:
    """A time in nanoseconds."""
    return round(seconds / NS)


class MomentStruct(ctypes.Structure):
    """``wmr_moment``."""

    _fields_ = [(name, ctypes.c_int64) for name in ("ros", "steady", "simulated")]


class ClocksStruct(ctypes.Structure):
    """``wmr_clocks``."""

    _fields_ = [
        ("longest", ctypes.c_int64),
        ("begun", ctypes.c_int64),
        ("before", MomentStruct),
        ("counts", ctypes.c_int64 * len(HAPPENINGS)),
    ]


class IntakeStruct(ctypes.Structure):
    """``wmr_intake``."""

    _fields_ = [
        *((name, ctypes.c_int64) for name in (
            "timeout", "stamp", "stamped", "arrived", "there", "late", "thawed", "taken")),
        ("refused", ctypes.c_int64 * REASONS),
    ]  # fmt: skip


class SightStruct(ctypes.Structure):
    """``wmr_sight``."""

    _fields_ = [
        ("points", ctypes.c_int64),
        ("blind", ctypes.c_int64),
        *((name, ctypes.c_double) for name in ("nearest", "nearest_at", "gap", "half")),
    ]


class BeamsStruct(ctypes.Structure):
    """``wmr_beams``."""

    _fields_ = [
        *((name, ctypes.c_double) for name in ("first", "step", "least", "most")),
        ("count", ctypes.c_int64),
        ("ranges", ctypes.c_void_p),
    ]


Functions: TypeAlias = "dict[str, ctypes._NamedFuncPointer]"
_RETURNS: dict[str, type | None] = {
    "clocks_see": ctypes.c_int64,
    "intake_take": ctypes.c_int64,
    "intake_refuse": ctypes.c_int64,
    "intake_age": ctypes.c_double,
    "intake_forget": None,
    "frame_fits": ctypes.c_int64,
    "is_rotation": ctypes.c_int64,
    "reason": ctypes.c_char_p,
}


@cache
def node_functions() -> Functions:
    """Functions that both nodes share, by their names without wmr_.  Raises CompilerError."""
    files = c_texts(*NODE_CORE, folder="ros2")
    path = build_library(files, name="node_core", flags=VISIBLE)
    return functions_of(ctypes.CDLL(str(path)), _RETURNS)


def functions_of(
    library: ctypes.CDLL, returns: Mapping[str, type | None], prefix: str = "wmr_"
) -> Functions:
    """Functions of a library by name, with their return types."""
    functions = {name: library[prefix + name] for name in returns}
    for name, function in functions.items():
        function.restype = returns[name]
    return functions


@cache
def reason_words() -> tuple[str, ...]:
    """Reasons for refusing messages, in the order of the C enumeration; the first is no reason."""
    tell = node_functions()["reason"]
    return tuple(tell(ctypes.c_int64(k)).decode() for k in range(REASONS))
