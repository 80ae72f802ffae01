"""The page that the tests look at, written once.

With `--every-case` it is compiled as it ships, with every law and the corridor of each, and for all
delays that are offered; tests/bits compares the bits of both levels, and test_story.py has a page's
corridors.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import wmr_ctrl
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.export.page import content


@pytest.fixture(scope="session")
def laws(request: pytest.FixtureRequest) -> tuple[str, ...]:
    """Those of the page."""
    every = request.config.getoption("every_case")
    return tuple(name for name in LAWS if every or name not in ("smc", "kanayama", "pursuit"))


@pytest.fixture(scope="session")
def page(
    request: pytest.FixtureRequest, laws: tuple[str, ...], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    tube = content._tube
    with pytest.MonkeyPatch.context() as patch:
        if request.config.getoption("every_case"):
            patch.delenv("WMR_CTRL_OPTIMIZE", raising=False)
        else:
            patch.setattr("wmr_ctrl.export.page.scenes.LATE", (0, 5))
            patch.setattr(
                content, "_tube", lambda setup, whole: setup.name == "prox" and tube(setup, whole)
            )
        return wmr_ctrl.write_page(tmp_path_factory.mktemp("page") / "robot.html", laws=laws)
