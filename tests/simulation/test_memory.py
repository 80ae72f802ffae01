"""Memory of a batch: alignment, key of the noise, and a library that can be loaded."""

import numpy as np
import pytest

from wmr_ctrl.core.errors import CompilerError
from wmr_ctrl.simulation.memory import ALIGNMENT, aligned, noise_key, opened, pointer_to


def test_arrays_are_zeros_where_vectors_want_them():
    for shape in ((3,), (5, 7), (1, 1, 9)):
        array = aligned(*shape)

        assert array.ctypes.data % ALIGNMENT == 0
        assert array.shape == shape
        assert not array.any()


def test_a_key_is_that_of_numpys_generator_and_another_for_each_seed():
    keys = [noise_key(seed) for seed in (0, 1, 2**40)]

    assert len(set(keys)) == 3
    assert all(0 <= word < 2**64 for key in keys for word in key)
    given = np.random.Philox(seed=1).state["state"]["key"]
    assert keys[1] == tuple(map(int, given))


def test_a_pointer_is_to_the_numbers_themselves(tmp_path):
    numbers = np.arange(3.0)
    pointer_to(numbers)[1] = 9.0

    assert numbers.tolist() == [0.0, 9.0, 2.0]
    (tmp_path / "loop.so").write_bytes(b"no library")
    with pytest.raises(CompilerError, match=r"cannot be loaded .* delete it and run again"):
        opened(str(tmp_path / "loop.so"))
