"""The page and the picture of an identification show its results."""

import numpy as np
import pytest

from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.report.identified import write_identification


def test_traces_foretell_as_the_score_says(found):
    """The drawn traces give the score: the predicted shares of the held-out variance.

    The filter restarts for the score, so the shares agree to 0.03.
    """
    traces = found.traces()
    rest = traces.t >= traces.held_out_from
    seen, foretold = traces.measured[rest], traces.foretold[rest]
    error = np.sum((foretold - seen) ** 2, axis=0)

    shares = 1 - error / np.sum((seen - seen.mean(axis=0)) ** 2, axis=0)

    assert shares == pytest.approx(found.score.foretold, abs=0.03)
    largest = np.nanmax(np.abs(traces.residual), axis=0)
    assert (largest <= np.array(found.bounds.dbar) * (1 + 1e-12)).all()


def test_another_suffix_is_refused_and_nothing_is_written(found, tmp_path):
    with pytest.raises(ResultFileError, match=r"\.png, \.svg, \.pdf"):
        write_identification(found, tmp_path / "fit.html", tmp_path / "fit.gif")
    assert list(tmp_path.iterdir()) == []
