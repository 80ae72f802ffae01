"""Files of an FMU or SSP: text from ``fmu/templates``, the archive, and the C sources.

The sources are the generated tables and kernels with the hand-written files that they need.
"""

import hashlib
import json
import math
import uuid
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from wmr_ctrl.codegen.dialect import HEADER
from wmr_ctrl.codegen.package import text_engine
from wmr_ctrl.codegen.resources import fmu_dir, runtime_dir
from wmr_ctrl.codegen.source import plain_sources
from wmr_ctrl.codegen.source import sources as kernel_sources
from wmr_ctrl.results import atomic_path, new_folder
from wmr_ctrl.world.scenario import scenario_hash

from .model_description import RUNTIME, FmuModel, Variable, orders

_EPOCH = (1980, 1, 1, 0, 0, 0)
LEVEL = 4
"""Level of compression of an archive: zlib's 6 takes over twice as long for 5 % less."""


def render(name: str, /, **values: object) -> str:
    """Text of the template ``name``; markup in XML and HTML is escaped."""
    markup = name.endswith((".xml", ".html", ".ssd", ".ssv"))
    engine = text_engine(fmu_dir() / "templates", markup=markup, blocks=markup)
    engine.filters["number"] = _number
    return engine.get_template(f"{name}.jinja").render(**values)


def write_archive(path: Path, files: Mapping[str, bytes], *, level: int = LEVEL) -> Path:
    """Write ``files`` (name inside the archive to content) to ``path``, atomically.

    ``level`` of compression, 0 for a file that is read immediately and deleted.  Its bytes depend
    only on the content.
    """
    with (
        new_folder(path.parent),
        atomic_path(path) as partial,
        zipfile.ZipFile(partial, "w") as archive,
    ):
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o755 << 16 if name.startswith("binaries/") else 0o644 << 16
            archive.writestr(entry, content, compresslevel=level)
    return path


COMMON = (
    "instance.c", "instance.h", "kind.h", "calls.h", "variables.h", "values.c", "values.h",
    "snapshot.c", "snapshot.h", "derivatives.c", "derivatives.h",
)  # fmt: skip
NAMESPACE = uuid.UUID("a2f3b9a0-6d0c-5b58-9a53-0d5f5c3f8f5e")


@dataclass(frozen=True)
class Sources:
    """Files by name, flat, and the token: a GUID of the content."""

    files: dict[str, str]
    token: str

    @property
    def units(self) -> list[str]:
        """The files to compile."""
        return [name for name in self.files if name.endswith(".c")]


def sources_of(model: FmuModel, version: int, *, arrays: bool = True) -> Sources:
    """All C of ``model`` for one version of FMI; ``arrays``: vectors have one value reference."""
    generated = kernel_sources(model.constants, model.kernels)
    files = {name: generated[name] for name in ("kernels.h", "kernels.c")}
    files |= plain_sources(model.derivatives, "jacobian") if model.derivatives else {}
    layer, runtime = fmu_dir() / "fmi", runtime_dir()
    paths = [
        *(layer / name for name in (*COMMON, f"kind_{model.kind}.c")),
        *sorted(layer.glob(f"fmi{version}*.c")),
        *sorted((layer / "headers").glob(f"fmi{version}*.h")),
        *(runtime / name for name in (*RUNTIME[model.kind], HEADER, "export.h")),
    ]
    files |= {path.name: path.read_text(encoding="utf-8") for path in paths}
    pairs = orders(model)
    rows = [(v, row_size(v, arrays and version == 3)) for v in model.variables]
    files["model.c"] = render(
        "model.c", identifier=model.identifier, rows=rows, orders=pairs,
        scenario_hash=scenario_hash(model.scenario),
    )  # fmt: skip
    if model.tables:
        files["loop_tables.h"] = render("loop_tables.h", tables=model.tables)
    content = json.dumps([model.identifier, sorted(files.items()), sorted(model.layout.items())])
    token = f"{{{uuid.uuid5(NAMESPACE, hashlib.sha256(content.encode()).hexdigest())}}}"
    more = ("ORDERS", len(pairs)), ("HAS_DERIVATIVES", int(bool(model.derivatives)))
    layout = [*model.layout.items(), *more]
    files["model.h"] = render("model.h", model=model, token=token, layout=layout)
    return Sources(files, token)


def row_size(variable: Variable, arrays: bool) -> int:
    """Elements of the row's value reference: 0 inside an array, its length at its head."""
    if not (arrays and variable.array):
        return 1
    return 0 if variable.index else variable.size


def _number(value: float) -> str:
    return repr(float(value)) if math.isfinite(value) else f"{'-' if value < 0 else ''}DBL_MAX"
