"""The page that the tests look at: written once, with every law, at the level at which it ships."""

from __future__ import annotations

from pathlib import Path

import pytest

import wmr_ctrl


@pytest.fixture(scope="session")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("WMR_CTRL_OPTIMIZE", raising=False)
        return wmr_ctrl.write_page(tmp_path_factory.mktemp("page") / "robot.html")
