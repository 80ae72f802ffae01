"""Types of the arrays that go from one part of the oracle to another."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
Words: TypeAlias = NDArray[np.uint64]
"""Random integers of 64 bits."""
