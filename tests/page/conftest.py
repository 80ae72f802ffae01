"""The page that the tests look at: written once, with every law.

With `--every-case` it is compiled as it ships, and has the corridor of every law; tests/bits
compares the bits of both levels, and test_story.py has a page's corridors.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import wmr_ctrl
from wmr_ctrl.page import content


@pytest.fixture(scope="session")
def page(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    tube = content._tube
    with pytest.MonkeyPatch.context() as patch:
        if request.config.getoption("every_case"):
            patch.delenv("WMR_CTRL_OPTIMIZE", raising=False)
        else:
            patch.setattr(
                content, "_tube", lambda setup, whole: setup.name == "prox" and tube(setup, whole)
            )
        return wmr_ctrl.write_page(tmp_path_factory.mktemp("page") / "robot.html")
