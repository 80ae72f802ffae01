"""The key that the C runtime makes of a seed is NumPy's."""

import ctypes as ct

import numpy as np

from tests.codegen.compiled import runtime_library
from wmr_ctrl.codegen.resources import runtime_dir


def test_a_seed_becomes_the_key_of_numpy(tmp_path):
    assert (runtime_dir() / "seed.c").is_file()
    seed_key = runtime_library(tmp_path, "seed").wmr_seed_key
    for seed in (0, 1, 7, 2**32 - 1, 2**32, 2**63 + 5):
        key = (ct.c_uint64 * 2)()
        seed_key(ct.c_uint64(seed), key)
        assert list(key) == np.random.SeedSequence(seed).generate_state(2, np.uint64).tolist()
