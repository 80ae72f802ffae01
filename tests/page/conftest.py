"""The page that the tests look at: written once, with every law.

With `--every-case` it is compiled as it ships; tests/bits compares the bits of both levels.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import wmr_ctrl


@pytest.fixture(scope="session")
def page(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        if request.config.getoption("every_case"):
            patch.delenv("WMR_CTRL_OPTIMIZE", raising=False)
        return wmr_ctrl.write_page(tmp_path_factory.mktemp("page") / "robot.html")
