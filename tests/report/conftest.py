"""Synthetic runs of 80 s that are quick to make and differ by scenario, law and seed."""

from contextlib import contextmanager

import pytest

from tests.simulation.campaign.conftest import campaign as campaign
from tests.simulation.campaign.conftest import fake_simulate as fake_simulate
from wmr_ctrl.report.drawing import Drawing


@contextmanager
def drawn_for_the_page(wanted):
    """To save time, draw only the pictures of these names, as SVG, and write empty files for the
    others.
    """
    whole = Drawing.save

    def save(drawing, folder):
        if wanted(drawing.name):
            return whole(drawing, folder, (".svg",))
        path = folder / f"{drawing.name}.svg"
        path.write_text("<svg/>")
        return (path,)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Drawing, "save", save)
        yield


@pytest.fixture
def few_pictures():
    """Two; test_write.py has one of each kind."""
    drawn = frozenset(("fig3a_trajectory", "limits_all_seeds"))
    with drawn_for_the_page(drawn.__contains__):
        yield drawn
