"""The script that draws the documentation's pictures still draws them."""

import pytest
from PIL import Image

from analysis import pictures
from tests.docs.pages import ROOT

pytestmark = pytest.mark.slow


def size_of(path):
    """Width and height."""
    with Image.open(path) as image:
        return image.size


def test_the_gallery_has_eight_pictures_that_are_there():
    targets = [target for _, target in pictures.in_gallery()]

    assert len(targets) == len(set(targets)) == 8
    assert set(targets) == set((ROOT / "docs/images/gallery").iterdir())


def test_a_picture_of_the_gallery_is_what_its_command_draws(tmp_path):
    ((command, there),) = (pair for pair in pictures.in_gallery() if pair[1].stem == "laws")
    pictures.by_command(command, tmp_path / there.name)

    assert size_of(tmp_path / there.name) == size_of(there)


@pytest.mark.parametrize("name", ["guard-dbar", "robot"])
def test_a_picture_is_drawn(name, tmp_path):
    path = tmp_path / f"{name}.png"
    with pictures.house_style():
        pictures.save(pictures.PICTURES[name](), path)

    assert size_of(path) == size_of(pictures.IMAGES / path.name)
