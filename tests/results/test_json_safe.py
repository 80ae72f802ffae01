"""Values made fit for strict JSON."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wmr_ctrl.results import json_safe

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.tuples(inner) | st.dictionaries(st.text(), inner),
    max_leaves=10,
)


@given(VALUES)
@pytest.mark.slow
def test_any_nesting_becomes_strict_json_and_stays_as_it_is_then(value: object) -> None:
    plain = json_safe(value)

    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    assert json_safe(plain) == plain


@pytest.mark.parametrize(
    ("value", "plain"),
    [
        (math.nan, None),
        ([1.5, math.inf], [1.5, None]),
        (np.float64("nan"), None),
        (np.int64(3), 3),
        (np.bool_(True), True),
        (np.array([[1.0, -math.inf]]), [[1.0, None]]),
        ({"a": (1, np.float64(0.5))}, {"a": [1, 0.5]}),
    ],
)
def test_numbers_without_a_json_name_become_null(value: object, plain: object) -> None:
    assert json_safe(value) == plain
    assert type(json_safe(value)) is type(plain)
