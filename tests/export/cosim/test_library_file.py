"""This machine's library in an unpacked FMU."""

from types import SimpleNamespace

import fmpy
import pytest

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.export.cosim.library_file import build_sources, place_of


def test_its_place_depends_on_the_version(tmp_path):
    name = "toy" + fmpy.sharedLibraryExtension

    assert place_of(tmp_path, 3, "toy").parts == ("binaries", fmpy.platform_tuple, name)
    assert place_of(tmp_path, 2, "toy").parts == ("binaries", fmpy.platform, name)


def test_without_sources_nothing_is_built(tmp_path):
    inside = place_of(tmp_path, 3, "toy")

    with pytest.raises(ArgumentError, match="names no sources that could be built instead"):
        build_sources(tmp_path, inside, SimpleNamespace(buildConfigurations=[]))
