"""Oversized data is refused by the size it declares, before it is counted or unpacked."""

import io
import zipfile

import pytest

from wmr_ctrl.core.errors import ScenarioError, WmrError
from wmr_ctrl.core.fields import values
from wmr_ctrl.export.cosim.slave import FmuFile
from wmr_ctrl.results import load_run
from wmr_ctrl.world.references.point_files import read_points

MOST = 100_000
"""Bytes that a packed file may hold in these tests; its own limit takes a second to pack."""
LAUGHS = "a0: &a0 [0]\n" + "".join(
    f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 30)
)
"""Aliases that expand to some 9^29 values."""


def zipped(name):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, b" " * 2 * MOST)
    return file.getvalue()


BOMBS = {
    "a.npz": (lambda: zipped("run.json"), load_run, "more than its own size"),
    "a.fmu": (
        lambda: zipped("modelDescription.xml"),
        lambda path: FmuFile(path, "plant"),
        "which is implausible for its size",
    ),
}


@pytest.mark.parametrize("name", BOMBS)
def test_packed_files_that_are_far_larger_unpacked(tmp_path, monkeypatch, name):
    make, read, reason = BOMBS[name]
    monkeypatch.setattr(values, "MOST_UNPACKED", MOST)
    monkeypatch.setattr(values, "RATIO", 1)
    file = tmp_path / name
    file.write_bytes(make())
    assert file.stat().st_size < MOST

    with pytest.raises(WmrError, match=reason):
        read(file)


@pytest.mark.parametrize("text", [LAUGHS, "poses: &a [*a]\n"], ids=["aliases", "holds itself"])
def test_a_path_with_more_values_than_it_has_letters(tmp_path, text):
    pytest.importorskip("yaml")
    (tmp_path / "way.yaml").write_text(text)

    with pytest.raises(ScenarioError, match="the anchor in line 1 has an alias"):
        read_points(tmp_path / "way.yaml")
