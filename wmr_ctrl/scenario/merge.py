"""One raw dictionary put over another: what ``extends`` and the defaults need."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from numbers import Real
from typing import Any

from wmr_ctrl.scenario.raw import section_dict
from wmr_ctrl.scenario.scenario import section_defaults
from wmr_ctrl.world.references import REFERENCES, Waypoints

Raw = dict[str, object]


def merge(base: Mapping[str, object], over: Mapping[str, object]) -> Raw:
    """Return ``base`` with ``over`` put on top: tables key by key, everything else as a whole.

    Another ``reference.kind`` replaces the whole reference.  A shorter ``clock.duration`` drops
    the base's changes that the run no longer reaches.
    """
    result = _over(base, over)
    if "reference" in over and _kind(over, _kind(base)) != _kind(base):
        result["reference"] = deepcopy(over["reference"])
    if "changes" not in over and "duration" in _table(over, "clock"):
        drop_unreached(result)
    return result


def _over(base: Mapping[str, Any], over: Mapping[str, Any]) -> Raw:
    result = deepcopy(dict(base))
    for key, value in over.items():
        both = isinstance(value, Mapping) and isinstance(result.get(key), Mapping)
        result[key] = _over(result[key], value) if both else deepcopy(value)
    if "file" in over:
        result.pop("points", None)
    elif "points" in over:
        result.pop("file", None)
    return result


def _table(raw: Mapping[str, object], key: str) -> Mapping[str, object]:
    table = raw.get(key)
    return table if isinstance(table, Mapping) else {}


def _kind(raw: Mapping[str, object], default: object = "circle") -> object:
    return _table(raw, "reference").get("kind", default)


def drop_unreached(raw: Raw) -> None:
    """Remove the changes at or after the run's end."""
    duration = _table(raw, "clock").get("duration")
    changes = raw.get("changes")
    if isinstance(duration, Real) and isinstance(changes, list):
        raw["changes"] = [change for change in changes if not _late(change, duration)]


def _late(change: object, duration: Real) -> bool:
    time = change.get("t") if isinstance(change, Mapping) else None
    return isinstance(time, Real) and time >= duration


def with_defaults(raw: Mapping[str, object]) -> Raw:
    """Return ``raw`` with every field that has a default filled in, so that each can be indexed."""
    defaults: Raw = {key: section_dict(part) for key, part in section_defaults().items()}
    kind = REFERENCES.get(str(_kind(raw)))
    if kind is not None and kind.section is not Waypoints:  # points have no default
        defaults["reference"] = section_dict(kind.section())
    return _over(defaults, raw)
