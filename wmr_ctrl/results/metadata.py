"""Everything of a run besides its columns, as one JSON object, and back."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from wmr_ctrl.results.monitor import Monitor
from wmr_ctrl.results.outcomes import Outcome
from wmr_ctrl.results.run import FloatArray, Run
from wmr_ctrl.results.settings import Settings
from wmr_ctrl.signals import Signal

_FORMAT = "wmr_ctrl run, version 1"
_LABELS = ("scenario", "law", "guard", "seed", "engine")


def metadata_of(run: Run) -> dict[str, object]:
    """All of a run but its columns, in values that JSON can hold without loss.

    Floats that JSON cannot name stand as the texts "inf", "-inf" and "nan".
    """
    return {
        "format": _FORMAT,
        **{name: getattr(run, name) for name in _LABELS},
        "outcome": run.outcome.value,
        "settings": _encoded(asdict(run.settings)),
        "monitor": _encoded(asdict(run.monitor)),
        "provenance": dict(run.provenance),
        "rows": run.rows,
        "signals": [asdict(signal) for signal in run.signals],
    }


def metadata_text(run: Run) -> str:
    """The metadata as indented JSON, in ASCII so that no encoding can harm it."""
    return json.dumps(metadata_of(run), indent=2, allow_nan=False)


def parsed(text: str | bytes) -> dict[str, object]:
    """The JSON object that a file holds; raises ValueError unless this release can read it."""
    metadata = json.loads(text)
    if not isinstance(metadata, dict) or metadata.get("format") != _FORMAT:
        raise ValueError(f"its description is not of the format {_FORMAT!r}")
    return metadata


def signals_in(metadata: Mapping[str, object]) -> tuple[Signal, ...]:
    """The signals that the file says it has, in order."""
    entries: Any = metadata["signals"]
    return tuple(Signal(**entry) for entry in entries)


def run_from(metadata: Mapping[str, object], columns: Mapping[str, FloatArray]) -> Run:
    """The run that a file holds; raises ValueError where rows are missing, or as Run does."""
    stored: Mapping[str, Any] = metadata
    run = Run(
        **{name: stored[name] for name in _LABELS},
        settings=Settings(**stored["settings"]),
        signals=signals_in(metadata),
        columns=columns,
        monitor=Monitor(**stored["monitor"]),
        outcome=Outcome(stored["outcome"]),
        provenance=stored["provenance"],
    )
    if run.rows != metadata["rows"]:
        raise ValueError(f"it holds {run.rows} of {metadata['rows']} rows")
    return run


def _encoded(value: object) -> object:
    if isinstance(value, dict):
        return {key: _encoded(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [_encoded(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    return value
