"""Write the live page into the site, by the command `wmr-ctrl page`."""

from __future__ import annotations

from pathlib import Path

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

NAME = "robot.html"
"""Name of the live page's file, beside the site's index."""


def _finished(app: Sphinx, exception: Exception | None) -> None:
    from click.testing import CliRunner

    from wmr_ctrl.cli.root import root

    if exception is not None or app.builder.format != "html" or "page" not in root.commands:
        return
    out = Path(app.outdir) / NAME
    if not out.exists():  # it does not hang on the pages' text
        done = CliRunner().invoke(root.commands["page"], ["--out", str(out)])
        if done.exit_code:
            raise ExtensionError(f"wmr-ctrl page failed: {done.output}{done.exception}")


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("build-finished", _finished)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
