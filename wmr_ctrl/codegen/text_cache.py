"""C text of kernels kept on disk, so that a second process does not write it again.

Reading a graph and finding its branches and loops takes a few tenths of a second; its serialised
form is the key, with the emitter's own source.  A folder that cannot be written is no error here.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

from wmr_ctrl.codegen.cache_folder import cache_dir
from wmr_ctrl.codegen.dialect import SCALAR, Dialect
from wmr_ctrl.codegen.emit import Kernel, definition
from wmr_ctrl.model import graph

_EMITTER = (
    "body",
    "branches",
    "dialect",
    "emit",
    "fold",
    "items",
    "preparation",
    "rolls",
    "together",
)


def cached_definition(item: Kernel, dialect: Dialect = SCALAR) -> str:
    """`emit.definition` of a kernel, from the cache if it was written before."""
    parts = (
        _fingerprint(),
        item.meaning,
        repr((item.name, item.inputs, item.outputs, item.prepared, dialect)),
    )
    key = hashlib.sha256("\0".join((*parts, item.function.serialize())).encode()).hexdigest()
    return _kept(key, lambda: definition(item, dialect))


def _kept(key: str, write: Callable[[], str]) -> str:
    path = cache_dir() / "text" / f"{key}.c"
    try:
        text = path.read_text(encoding="utf-8")
        if text.endswith("}\n"):
            return text
    except OSError:
        pass  # not there yet, or not readable: it is written anew
    text = write()
    _store(path, text)
    return text


def _store(path: Path, text: str) -> None:
    """Put the text in place by renaming, so that no reader sees half of it."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix="writing-")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(name, path)
    except OSError:
        return


@cache
def _fingerprint() -> str:
    """Hash of the emitter's source: another emitter writes another text."""
    folder = Path(__file__).parent
    digest = hashlib.sha256()
    for path in (Path(graph.__file__), *(folder / f"{name}.py" for name in _EMITTER)):
        digest.update(path.read_bytes())
    return digest.hexdigest()
