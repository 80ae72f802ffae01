"""Equality of two runs in every bit."""

import numpy as np

from wmr_ctrl.results.formats import metadata_text


def runs_equal(run_a, run_b):
    """True if two runs are equal in every bit, description included.

    Unlike with ==, a NaN equals a NaN, and 0.0 differs from -0.0.
    """
    if metadata_text(run_a) != metadata_text(run_b):
        return False
    pairs = ((column, run_b.columns[name]) for name, column in run_a.columns.items())
    return all(
        np.array_equal(a, b, equal_nan=True)
        and ((np.signbit(a) == np.signbit(b)) | np.isnan(a)).all()
        for a, b in pairs
    )
