"""The laws' gains as the scenario layer wants them told."""

from __future__ import annotations

from typing import Any

Docs = dict[str, dict[str, tuple[Any, str, str]]]


def gains_docs() -> Docs:
    """Default, unit and meaning of every gain, by law; the kinematic loop's first."""
    from wmr_ctrl.control.setup import KINEMATICS
    from wmr_ctrl.laws import LAWS
    from wmr_ctrl.model.auxiliary import KinematicGains

    tables: dict[str, type] = {KINEMATICS: KinematicGains}
    tables |= {law: LAWS[law].gains for law in LAWS}
    return {law: _documented(gains) for law, gains in tables.items()}


def _documented(gains: type) -> dict[str, tuple[Any, str, str]]:
    from wmr_ctrl.scenario import quantities

    return {name: (what.default, what.unit, what.doc) for name, what in quantities(gains)}
