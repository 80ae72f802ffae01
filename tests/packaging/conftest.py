"""The project as users get it: built once, installed into a separate environment."""

from __future__ import annotations

import os
import shutil
import site
import subprocess
import sys
import venv
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.architecture.tree import ROOT
from tests.commands import finished

NOT_COPIED = shutil.ignore_patterns(
    ".git", ".venv", ".*_cache", ".hypothesis", "__pycache__", "dist", "build"
)


@dataclass(frozen=True)
class Installed:
    """An environment with the wheel in it, and an empty folder to work in."""

    folder: Path
    work: Path

    @property
    def programs(self):
        return self.folder / ("Scripts" if os.name == "nt" else "bin")

    def run(self, *arguments, program="wmr-ctrl", timeout=300.0, **environment):
        """Run a program with no compiler on PATH and none of this process's Python settings."""
        kept = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        return subprocess.run(
            [str(self.programs / program), *arguments],
            cwd=self.work,
            env={**kept, "PATH": str(self.programs), **environment},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """Folder with the source archive, and the wheel made from that archive."""
    base = tmp_path_factory.mktemp("built")
    shutil.copytree(ROOT, base / "tree", ignore=NOT_COPIED)
    (base / "tree/fmu/runtime/left_over.o").write_bytes(b"a build product")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(base / "dist")]
    finished([*command, str(base / "tree")], timeout=300)
    shutil.rmtree(base / "tree")
    return base / "dist"


@pytest.fixture(scope="session")
def installed(built, tmp_path_factory):
    """The wheel alone in a fresh environment; dependencies come from where these tests run."""
    base = tmp_path_factory.mktemp("installed")
    venv.create(base / "venv", with_pip=False, symlinks=os.name != "nt")
    target = Installed(base / "venv", base / "work")
    target.work.mkdir()
    python = next(target.programs.glob("python*"))
    pip = [sys.executable, "-m", "pip", "--python", str(python)]
    wheel = next(built.glob("*.whl"))
    finished([*pip, "install", "--no-deps", "--no-index", "-q", str(wheel)])
    packages = next(target.folder.rglob("site-packages"))
    (packages / "dependencies.pth").write_text("\n".join(site.getsitepackages()) + "\n")
    return target
