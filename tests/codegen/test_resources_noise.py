"""The noise's bits, on compilers with and without 128-bit integers."""

import ctypes as ct

import numpy as np
import pytest

from tests.codegen.compiled import runtime_library

BLOCK = ct.c_uint64 * 4


@pytest.mark.parametrize("flag", ["-DNATIVE", "-U__SIZEOF_INT128__"], ids=["64 bit", "32 bit"])
def test_noise_is_philox_with_integers_of(flag, tmp_path):
    """Counters and keys whose halves carry: NumPy's block of counter c is ours of c + 1."""
    philox = runtime_library(tmp_path, "noise", flag).wmr_philox
    draw = np.random.default_rng(3)
    for _ in range(200):
        before, key = (draw.integers(0, 2**64 - 1, size, dtype=np.uint64) for size in (4, 2))
        out, counter = BLOCK(), BLOCK(*map(int, before))
        counter[0] += 1
        philox(counter, (ct.c_uint64 * 2)(*map(int, key)), out)
        assert list(out) == np.random.Philox(key=key, counter=before).random_raw(4).tolist()
