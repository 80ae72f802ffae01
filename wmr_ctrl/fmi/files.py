"""Files of an FMU or SSP: text from the templates of ``fmu/templates``, and the archive."""

import zipfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from wmr_ctrl.codegen.resources import fmu_dir
from wmr_ctrl.results import atomic_path, make_folder

_EPOCH = (1980, 1, 1, 0, 0, 0)


def render(name: str, **values: object) -> str:
    """Text of the template ``name``; markup in XML and HTML is escaped."""
    engine = _environment(name.endswith((".xml", ".html", ".ssd", ".ssv")))
    return engine.get_template(f"{name}.jinja").render(**values)


@cache
def _environment(escape: bool) -> Environment:
    return Environment(
        loader=FileSystemLoader(fmu_dir() / "templates"),
        autoescape=escape,
        undefined=StrictUndefined,
        trim_blocks=escape,
        lstrip_blocks=escape,
        keep_trailing_newline=True,
    )


def write_archive(path: Path, files: Mapping[str, bytes]) -> Path:
    """Write ``files`` (name inside the archive to content) to ``path``, whole or not at all.

    Its bytes depend on the content alone.
    """
    make_folder(path.parent)
    with (
        atomic_path(path) as partial,
        zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o755 << 16 if name.startswith("binaries/") else 0o644 << 16
            archive.writestr(entry, content)
    return path
