"""This machine's library in an unpacked FMU."""

import shutil
from types import SimpleNamespace

import fmpy
import pytest

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.export.cosim.library_file import build_sources, place_of, try_to_load


def test_its_place_depends_on_the_version(tmp_path):
    name = "toy" + fmpy.sharedLibraryExtension

    assert place_of(tmp_path, 3, "toy").parts == ("binaries", fmpy.platform_tuple, name)
    assert place_of(tmp_path, 2, "toy").parts == ("binaries", fmpy.platform, name)


def test_what_is_missing_misnamed_or_damaged_is_told(tmp_path):
    inside = place_of(tmp_path, 3, "toy")
    library = tmp_path / inside
    with pytest.raises(ArgumentError, match="it is built for no platform"):
        try_to_load(tmp_path, inside)

    library.parent.mkdir(parents=True)
    library.with_stem("other").write_bytes(b"no library")
    with pytest.raises(ArgumentError, match=f"but other{inside.suffix} there"):
        try_to_load(tmp_path, inside)

    shutil.move(library.with_stem("other"), library)
    with pytest.raises(ArgumentError, match="cannot be loaded on this machine"):
        try_to_load(tmp_path, inside)


def test_without_sources_nothing_is_built(tmp_path):
    inside = place_of(tmp_path, 3, "toy")

    with pytest.raises(ArgumentError, match="names no sources that could be built instead"):
        build_sources(tmp_path, inside, SimpleNamespace(buildConfigurations=[]))
