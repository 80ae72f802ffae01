"""The page and the picture of an identification say what was identified."""

import re
from importlib import import_module
from xml.etree import ElementTree

import numpy as np
import pytest

from wmr_ctrl.core.errors import ResultFileError
from wmr_ctrl.report.identified import write_identification
from wmr_ctrl.report.style import shown

module = import_module("wmr_ctrl.identification.identification")


def test_traces_foretell_as_the_score_says(found):
    """Shares of the held-out variance, from what is drawn; the filter begins anew for the score."""
    traces = found.traces()
    rest = traces.t >= traces.held_out_from
    seen, foretold = traces.measured[rest], traces.foretold[rest]
    error = np.sum((foretold - seen) ** 2, axis=0)

    shares = 1 - error / np.sum((seen - seen.mean(axis=0)) ** 2, axis=0)

    assert shares == pytest.approx(found.score.foretold, abs=0.03)
    largest = np.nanmax(np.abs(traces.residual), axis=0)
    assert (largest <= np.array(found.bounds.dbar) * (1 + 1e-12)).all()


@pytest.mark.slow
def test_the_page_has_every_number_and_needs_nothing_else(found, tmp_path):
    page, plot = tmp_path / "fit.html", tmp_path / "fit.svg"

    write_identification(found, page, plot)

    text = page.read_text()
    for item in found.parameters.values():
        assert shown(item.value, 4) in text
        assert item.verdict in text
    for value in (*found.bounds.dbar, *found.bounds.M_min, *found.bounds.delay):
        assert shown(value, 4) in text
    assert found.bounds.sentence in text
    assert set(re.findall(r'(?:src|href)="([^"#][^"]{0,14})', text)) == {"data:image/svg+"}
    assert ElementTree.parse(plot).getroot().tag.endswith("svg")


def test_another_suffix_is_refused_and_nothing_is_written(found, tmp_path):
    with pytest.raises(ResultFileError, match=r"\.png, \.svg, \.pdf"):
        write_identification(found, tmp_path / "fit.html", tmp_path / "fit.gif")
    assert list(tmp_path.iterdir()) == []
