"""Compile what a node needs, so that it configures quickly: ``python -m wmr_ctrl.ros2 prepare``."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from wmr_ctrl.control.default_law import law_of
from wmr_ctrl.control.filter.gate import ODOMETRY_USES
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.world.scenario import load_scenario

from .c_node import GIVEN, node_settings
from .drive_core import DriveCore, DriveSettings
from .filter_core import FilterCore
from .parameters import DRIVE


def prepare(source: str, words: Sequence[str]) -> Iterator[str]:
    """Fill the cache for both nodes of a scenario; yields the name of each that is ready.

    ``words`` are parameters of the nodes, NAME:=VALUE.  Without ``odometry`` all its uses are
    compiled.  Raises WmrError for a scenario or parameter that no node accepts.
    """
    given = dict(_pair(word) for word in words)
    law = given.pop("law", None)
    settings = node_settings([f"{key}={value}" for key, value in given.items() if key in GIVEN])
    gate = settings.gate
    scenario = load_scenario(source)
    if scenario.filter.kind != "none":
        for use in [given["odometry"]] if "odometry" in given else ODOMETRY_USES:
            used, frame = replace(gate, odometry=use), scenario.ros.base_frame
            FilterCore(scenario, used, frame, settings.sight)
            yield f"filter, odometry {use}"
    late = gate.odometry_timeout
    driven = replace(gate, command_timeout=late, odometry="required")
    chosen = law_of(scenario, law)
    DriveCore(settle(scenario, chosen), DriveSettings(gate=driven))
    yield f"drive, law {chosen}"


def _pair(word: str) -> tuple[str, str]:
    name, there, value = word.partition(":=")
    if not there or name not in {*GIVEN, *DRIVE}:
        raise ArgumentError(
            f"{word!r} must be NAME:=VALUE with a parameter of a node: "
            f"{', '.join(dict.fromkeys([*GIVEN, *DRIVE]))}."
        )
    return name, value
