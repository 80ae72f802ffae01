"""The script that draws the documentation's pictures still draws them."""

from __future__ import annotations

import shutil

import pytest
from PIL import Image

from analysis import pictures
from tests.docs.pages import ROOT

pytestmark = pytest.mark.slow
REPORTED = {"velocity", "stress"}
"""Drawings of the report, whose runs and figures have tests of their own."""


def size_of(path):
    """Width and height."""
    with Image.open(path) as image:
        return image.size


def test_the_gallery_has_eight_pictures_by_its_commands(tmp_path, monkeypatch):
    monkeypatch.setattr(pictures, "ROOT", tmp_path)
    (tmp_path / "docs" / "images").mkdir(parents=True)
    shutil.copy(ROOT / "docs" / "gallery.md", tmp_path / "docs")
    pictures.gallery()
    made = {path.name for path in (tmp_path / "docs" / "images" / "gallery").iterdir()}

    assert len(made) == 8
    for name in made:
        assert size_of(tmp_path / "docs/images/gallery" / name) == size_of(
            ROOT / "docs/images/gallery" / name
        )


@pytest.mark.parametrize("name", sorted(set(pictures.PICTURES) - REPORTED))
def test_a_picture_is_drawn(name, tmp_path):
    path = tmp_path / f"{name}.png"
    with pictures.house_style():
        pictures.save(pictures.PICTURES[name](), path)

    assert size_of(path) == size_of(pictures.IMAGES / path.name)
