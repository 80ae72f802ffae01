"""The page that the tests look at: written once, with every law."""

from __future__ import annotations

from pathlib import Path

import pytest

import wmr_ctrl


@pytest.fixture(scope="session")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return wmr_ctrl.write_page(tmp_path_factory.mktemp("page") / "robot.html")
