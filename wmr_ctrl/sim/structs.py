"""The C structs of fmu/runtime/loop.h as ctypes, for one library's sizes."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Mapping
from functools import cache
from typing import Any

REAL, WORD, LONG = ct.c_double, ct.c_uint64, ct.c_int64
REALS, LONGS = ct.POINTER(REAL), ct.POINTER(LONG)


class Settings(ct.Structure):
    """``wmr_settings``: what stays the same during a run."""

    _fields_ = (
        ("control", REAL), ("plant", REAL), ("samples", LONG), ("substeps", LONG),
        ("reference_parameters", REALS), ("controller_parameters", REALS),
        ("estimator_parameters", REALS),
        ("plant_parameters", REALS), ("phase_start", LONGS), ("phases", LONG),
        ("plant_start", REALS), ("controller_start", REALS), ("v_u1", REAL * 2),
        ("pose_every", LONG), ("pose_noise", REAL), ("correction", REAL),
        ("velocity_noise", REAL * 2),
        ("torque_std", REAL), ("torque_truncate", REAL), ("push_torque", REAL * 2),
        ("key", WORD * 2),
        ("actuator_ideal", LONG), ("delay_steps", LONG), ("lag_decay", REAL), ("delay_line", REALS),
    )  # fmt: skip


class Call(ct.Structure):
    """``wmr_call``: addresses of a law's inputs, parameters, memory and outputs."""

    _fields_ = tuple((name, ct.c_void_p) for name in ("u", "p", "x", "y"))


def loop_struct(systems: Mapping[str, Any]) -> type[ct.Structure]:
    """``wmr_loop`` for the state sizes that the manifest gives."""
    nx = {role: systems[role]["sizes"]["NX"] for role in ("plant", "controller", "estimator")}
    return _loop_struct(nx["plant"], nx["controller"], nx["estimator"])


@cache
def _loop_struct(plant: int, controller: int, estimator: int) -> type[ct.Structure]:
    class Loop(ct.Structure):
        """What a run changes."""

        _fields_ = (
            ("sample", LONG), ("step", LONG), ("phase", LONG),
            ("plant", REAL * plant), ("controller", REAL * (controller + 1)),
            ("estimate", REAL * estimator),
            ("applied", REAL * 2), ("speed_max", REAL * 2), ("violations", LONG),
            ("first_step", LONG), ("first_axis", LONG),
            ("stop", LONG), ("stop_step", LONG), ("stop_axis", LONG),
        )  # fmt: skip

    return Loop
