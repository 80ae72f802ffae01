"""Values as JSON can hold them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np


def json_safe(value: object) -> object:
    """``value`` in plain dicts, lists, texts and numbers; null (None) for inf and NaN.

    NumPy scalars and arrays become numbers and lists.
    """
    if isinstance(value, Mapping):
        return {str(key): json_safe(item) for key, item in value.items()}
    if isinstance(value, np.generic | np.ndarray):
        return json_safe(value.tolist())
    if isinstance(value, list | tuple):
        return [json_safe(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
