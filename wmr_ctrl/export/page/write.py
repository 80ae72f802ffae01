"""Write the page: settle, compile, and combine everything in one file."""

import base64
import gzip
import json
from collections.abc import Callable, Sequence
from pathlib import Path

from wmr_ctrl.control.given import default_law
from wmr_ctrl.control.laws import LAWS
from wmr_ctrl.core.errors import ArgumentError, UnknownNameError
from wmr_ctrl.report.style import page_environment
from wmr_ctrl.results.files import atomic_text, check_writable
from wmr_ctrl.simulation.many import checked_seeds
from wmr_ctrl.world.scenario import Scenario

from .content import Content, content_of
from .module import build_module, toolchain
from .scenes import is_story, scenes

ALONE = ("engine.js", "run.js")
"""Scripts that need no document, in order: node runs them too."""
LARGEST_SEED = 2**53
"""Numbers of a browser are doubles."""
PUSHES = (0.6, 2.0, 6.0)
"""Forces of pushes by hand [N], for each kg of the robot."""
SETTLING = 0.3
"""Share of the time before anything is compiled, about."""
SHOWING = ("fleet.js", "settings.js", "link.js", "charts.js", "plane.js", "page.js")


def write_page(
    out: str | Path,
    scenario: Scenario,
    laws: Sequence[str] | None = None,
    *,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write the page to the file ``out``, atomically; returns its path.

    For the paper's simulation it tells a story in five steps; for a base that takes velocities it
    compares ways to limit commands.  ``laws``: the choices; by default all in the story, else the
    scenario's own.  ``progress`` is called with the share that is done.  Raises UnknownNameError
    for a law, ArgumentError for the seed, ScenarioError for an unsuitable scenario, CompilerError
    without zig, ResultFileError if the file cannot be written.
    """
    checked_seeds([seed])
    if seed >= LARGEST_SEED:
        raise ArgumentError(
            f"seed = {seed} is too large for a browser, whose whole numbers end at 2^53. Choose a "
            "smaller one."
        )
    target = check_writable(out)
    for name in laws or ():
        if name not in LAWS:
            raise UnknownNameError("law", name, tuple(LAWS))
    usual = LAWS if is_story(scenario) else (default_law(scenario).name,)
    chosen = tuple(dict.fromkeys(laws or usual))

    tell = progress or (lambda share: None)
    toolchain()  # what is missing is said before anything is worked out
    shown = scenes(scenario, chosen)
    content = content_of(shown, chosen, seed, lambda share: tell(SETTLING * share))
    rest = 1 - SETTLING
    module = build_module(content.loops, content.room, lambda share: tell(SETTLING + rest * share))
    text = page_text(content, module)
    with atomic_text(target) as file:
        file.write(text)
    return target


def page_text(content: Content, module: bytes) -> str:
    """The page with its module."""
    folder = Path(__file__).parent / "templates"
    scripts = {name: (folder / name).read_text(encoding="utf-8") for name in (*ALONE, *SHOWING)}
    script_data = json.dumps(content.data, allow_nan=False, separators=(",", ":"))
    template = page_environment("wmr_ctrl.export.page").get_template("page.html.j2")
    return template.render(
        title=content.data["scenes"][0]["scenario"],
        scenes=content.data["scenes"],
        laws=content.data["laws"],
        groups=content.data["groups"],
        filtered=content.data["filtered"],
        forces=[float(f"{share * content.mass:.2g}") for share in PUSHES],
        loops=len(content.loops),
        size=len(module),
        version=content.data["version"],
        style=(folder / "page.css").read_text(encoding="utf-8"),
        told=script_data.replace("<", "\\u003c"),  # so that no text ends the script element
        module=base64.b64encode(gzip.compress(module, 9, mtime=0)).decode(),
        alone="\n".join(scripts[name] for name in ALONE),
        showing="\n".join(scripts[name] for name in SHOWING),
    )
