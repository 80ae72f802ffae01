"""The page on extending: each example is written to a file, registered, and does what is said."""

import importlib.util
import re
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

import wmr_ctrl
from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.results.figures import FIGURES
from wmr_ctrl.world.references.registry import REFERENCES
from wmr_ctrl.world.registry import EFFECTS

PAGE = Path(__file__).parents[2] / "docs" / "extending.md"
BLOCKS = re.findall(r"```python\n# (file: (\w+)\.py|use)\n(.*?)```", PAGE.read_text("utf-8"), re.S)
FILES = {name: code for _, name, code in BLOCKS if name}
USES = dict(zip(FILES, (code for kind, _, code in BLOCKS if kind == "use"), strict=True))


def module_of(name, folder):
    path = folder / f"{name}.py"
    path.write_text(FILES[name], "utf-8")
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # entry points and dataclasses look there
    spec.loader.exec_module(module)
    return module


@pytest.fixture(params=FILES)
def example(request, tmp_path, monkeypatch):
    """Name and module of an example that stands in its registry."""
    name = request.param
    module = module_of(name, tmp_path)
    if hasattr(module, "LAW"):
        entry = EntryPoint(name, f"{name}:LAW", "wmr_ctrl.laws")
        monkeypatch.setitem(LAWS.__dict__, "plugins", {name: entry})
    if hasattr(module, "KIND"):
        monkeypatch.setitem(REFERENCES.__dict__, "plugins", (module.KIND,))
    if hasattr(module, "FIGURE"):
        monkeypatch.setitem(FIGURES.__dict__, "plugins", (module.FIGURE,))
    if hasattr(module, "EFFECT"):
        monkeypatch.setitem(EFFECTS.__dict__, "plugins", (module.EFFECT,))
    yield name, module
    del sys.modules[name]


@pytest.mark.slow_but("my_law", "my_figure")
def test_it_does_what_the_page_says(example):
    name, module = example

    exec(compile(USES[name], f"{PAGE.name}: {name}", "exec"), {"wmr_ctrl": wmr_ctrl, name: module})


def test_every_kind_of_extension_is_shown():
    page = PAGE.read_text("utf-8")

    assert set(FILES) == {
        "my_law", "my_reference", "my_sensor", "my_disturbance", "my_drive", "my_figure",
    }  # fmt: skip
    for group in ("laws", "references", "effects", "figures"):
        assert f"`wmr_ctrl.{group}`" in page
