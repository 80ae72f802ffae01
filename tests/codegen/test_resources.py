"""The key that the C runtime makes of a seed is NumPy's."""

import ctypes as ct
import shutil

import numpy as np

from tests.compilers import compile_in
from wmr_ctrl.codegen.resources import runtime_dir
from wmr_ctrl.codegen.toolchain import find_toolchain


def test_a_seed_becomes_the_key_of_numpy(tmp_path):
    for name in ("seed.c", "seed.h"):
        shutil.copy(runtime_dir() / name, tmp_path)
    flags = ["-std=c99", "-shared", "-fPIC", "seed.c", "-o", "seed.so"]
    compile_in(tmp_path, [*find_toolchain().command, *flags])
    seed_key = ct.CDLL(str(tmp_path / "seed.so")).wmr_seed_key
    for seed in (0, 1, 7, 2**32 - 1, 2**32, 2**63 + 5):
        key = (ct.c_uint64 * 2)()
        seed_key(ct.c_uint64(seed), key)
        assert list(key) == np.random.SeedSequence(seed).generate_state(2, np.uint64).tolist()
