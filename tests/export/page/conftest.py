"""The page for these tests, written once.

It is compiled without optimisation, with some laws and the corridor of one, and for two of the
offered delays. tests/bits compares the bits of both levels, and test_page_story.py has a page's
corridors.
"""

import pytest

import wmr_ctrl
from wmr_ctrl.export.page import content


@pytest.fixture(scope="session")
def laws():
    """Laws that the page offers."""
    return "pid", "mb", "nn", "prox"


@pytest.fixture(scope="session")
def page(laws, tmp_path_factory):
    tube = content._tube
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("wmr_ctrl.export.page.scenes.LATE", (0, 5))
        patch.setattr(
            content, "_tube", lambda setup, whole: setup.name == "prox" and tube(setup, whole)
        )
        return wmr_ctrl.write_page(tmp_path_factory.mktemp("page") / "robot.html", laws=laws)
