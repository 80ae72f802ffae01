"""The structures of hand.h as ctypes sees them."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .setup import Case, Setup

Double, Int64 = ctypes.c_double, ctypes.c_int64
Pair = Double * 2
Field = tuple[str, Any]
Kind = TypeVar("Kind", bound=ctypes.Structure)


def _doubles(names: str) -> list[Field]:
    return [(name, Double) for name in names.split()]


def _pairs(names: str) -> list[Field]:
    return [(name, Pair) for name in names.split()]


class HandSetup(ctypes.Structure):
    """``hand_setup``: parameters that a person would write by hand."""

    _fields_ = [
        *_doubles("m inertia mu r l g v_s"),
        ("k", Double * 3),
        *_pairs("v_u1 v_u2"),
        ("clip", Double),
        *_pairs("mb_rho nn_rho1 nn_gamma nn_sigma"),
        *_doubles("nn_eta nn_ratio_cap"),
        ("period", Double),
    ]


class HandAxis(ctypes.Structure):
    """``hand_axis``: one axis of the barrier."""

    _fields_ = _doubles("u1 u2 top delta inv_delta edge")


class HandLaw(ctypes.Structure):
    """``hand_law``: the prepared constants of both laws."""

    _fields_ = [
        ("axis", HandAxis * 2),
        ("k", Double * 3),
        ("mass", Pair),
        *_doubles("coulomb inv_v_s wheel_force wheel_moment"),
        *_pairs("mb_rho nn_rho1 nn_keep nn_learn"),
        *_doubles("nn_inv_eta2 nn_far nn_ratio_cap nn_inv_cap"),
    ]


class HandCase(ctypes.Structure):
    """``hand_case``: one closed loop."""

    _fields_ = [
        ("initial", Double * 5),
        *_doubles("radius rate control plant"),
        ("samples", Int64),
        ("substeps", Int64),
        *_doubles("noise_std t_change m inertia mu m_first inertia_first mu_first"),
        ("key", ctypes.c_uint64 * 2),
    ]


class HandResult(ctypes.Structure):
    """``hand_result``: what the monitor of one closed loop found."""

    _fields_ = [("state", Double * 5), ("max_abs_v", Pair), ("violations", Int64), ("steps", Int64)]


class HandPlant(ctypes.Structure):
    """``hand_plant``: the plant's constants for one step."""

    _fields_ = _doubles("h inv_m inv_inertia mu_g inv_v_s inv_r arm")


STRUCTURES = (HandSetup, HandLaw, HandCase, HandResult, HandPlant, HandAxis)
"""In the order of ``hand_sizes``."""


def fill_setup(setup: Setup) -> HandSetup:
    """Copy a Setup field by field; the names are the same."""
    return _filled(HandSetup, {name: getattr(setup, name) for name, _ in _fields(HandSetup)})


def fill_case(case: Case) -> HandCase:
    """Copy a Case; the noise's key comes from its seed."""
    later = dict(zip(("m", "inertia", "mu"), case.later, strict=True))
    first = dict(zip(("m_first", "inertia_first", "mu_first"), case.first, strict=True))
    special = {**later, **first, "key": tuple(int(word) for word in noise_key(case.seed))}
    names = [name for name, _ in _fields(HandCase)]
    return _filled(HandCase, {n: special[n] if n in special else getattr(case, n) for n in names})


def noise_key(seed: int) -> NDArray[np.uint64]:
    """Key of Philox4x64 that belongs to a seed, shape (2,), uint64."""
    return np.random.SeedSequence(seed).generate_state(2, np.uint64).astype(np.uint64)


def _fields(kind: type[ctypes.Structure]) -> Iterable[Field]:
    return kind._fields_  # type: ignore[return-value]


def _filled(kind: type[Kind], values: dict[str, Any]) -> Kind:
    """Return the structure with tuples turned into C arrays."""
    made = kind()
    for name, value in values.items():
        slot = getattr(made, name)
        if isinstance(slot, ctypes.Array):
            slot[:] = _same_length(name, slot, value)
        else:
            setattr(made, name, value)
    return made


def _same_length(name: str, slot: ctypes.Array[Any], value: Sequence[Any]) -> list[Any]:
    if len(slot) != len(value):
        raise ValueError(f"{name} has {len(value)} entries where hand.h has {len(slot)}.")
    return list(value)
