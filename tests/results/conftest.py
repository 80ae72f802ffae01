"""A builder of synthetic runs: every logged column is zero unless a test says otherwise."""

import numpy as np

from wmr_ctrl.core.signals import LOG_HEAD
from wmr_ctrl.results import Monitor, Run, Settings, outcome_of


def build(
    *,
    rows=None,
    duration=1.0,
    control=0.01,
    split=None,
    rms_from=2.0,
    monitor=None,
    extra=(),
    labels=None,
    provenance=None,
    dbar=None,
    **columns,
):
    """A run of ``duration`` s whose ``columns`` are given as constants or arrays, others zero."""
    half = duration / 2 if split is None else split
    settings = Settings(control, control / 10, duration, (1.0, 1.5), half, rms_from, dbar=dbar)
    count = settings.samples if rows is None else rows
    signals = (*LOG_HEAD, *extra)
    log = {s.name: np.zeros((count, s.size) if s.size > 1 else count) for s in signals}
    log["t"] = control * np.arange(count)
    for name, values in columns.items():
        log[name] = np.broadcast_to(values, log[name].shape)
    seen = monitor or Monitor((0.5, 0.5))
    named = {"scenario": "toy", "law": "nn", "guard": False, "seed": 0, "engine": "native"}
    labelled = {**named, **(labels or {})}
    return Run(
        **labelled,
        settings=settings,
        signals=signals,
        columns=log,
        monitor=seen,
        outcome=outcome_of(seen, labelled["guard"]),
        provenance=provenance or {},
    )
