"""A law's compiled controller, called from Python."""

import numpy as np
import pytest

from tests.papers_robot import paper
from wmr_ctrl.codegen.build import build_law
from wmr_ctrl.control.setup import settle
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.simulation.compiled_law import START_SAMPLE, CompiledLaw, seconds_of


@pytest.fixture
def law():
    return CompiledLaw(build_law(settle(paper(), "pid")))


def test_a_sample_moves_the_memory_until_it_is_reset(law):
    law.u = START_SAMPLE
    first = law.step().copy()

    assert np.isfinite(first).all()
    assert law.x.any()
    law.step()
    law.reset()
    assert np.array_equal(law.step(), first)


def test_arrays_keep_their_size_and_the_least_of_several_times_is_told(law, monkeypatch):
    kept = law.u
    law.u = [0.5] * 12

    assert law.u is kept
    with pytest.raises(ArgumentError, match="u takes 12 real numbers, not an array of float64"):
        law.u = [0.5] * 11
    monkeypatch.setattr("timeit.repeat", lambda *_, **__: [3.0, 1.0, 2.0])
    assert seconds_of(law) == 1.0
