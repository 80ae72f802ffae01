"""Animations of a run: the robot and the desired pose on the path, as a page or a GIF."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from wmr_ctrl.core.fields.files import AnyPath
from wmr_ctrl.results import Run, atomic_path
from wmr_ctrl.simulation.batch import Progress

from . import style
from .drawing import target_of, write_html
from .scene import BODY, TRACK, WHEEL, Scene, scene_of, with_tubes
from .stage import frames

SUFFIXES = (".gif", ".html")
_FRAMES = {".gif": 250, ".html": 2000}
"""Most frames of an animation."""
GIF_MILLISECONDS = 80
"""Time that a frame of a GIF is shown; whole runs thus take 20 s."""
_GIF_COLOURS = 48


def animate_runs(runs: Sequence[Run], path: AnyPath, progress: Progress | None = None) -> None:
    """Animate one run or several at once: a .html (with play and slider) or .gif file.

    Raises as `Run.animate`, and ArgumentError for runs that one picture cannot show (`scene_of`).
    """
    target = target_of(path, SUFFIXES, "a run is animated as .gif, .html")
    scene = with_tubes(scene_of(runs, _FRAMES[target.suffix.lower()]), runs)
    with atomic_path(target) as scratch:
        if target.suffix.lower() == ".html":
            write_page(scene, scratch, [run.explanation for run in runs])
        else:
            _write_gif(scene, scratch, progress)


# -- the page -----------------------------------------------------------------------------------


def write_page(scene: Scene, path: Path, said: Sequence[str]) -> None:
    """Write the page, with a sentence on each robot."""
    laws = {f"law{place}": one.colour for place, one in enumerate(scene.actors)}
    colours = {**laws, "muted": style.MUTED, "limit": style.LIMIT, "ink": style.INK,
               "paper": style.PAPER, "line": style.RULE_LINE}  # fmt: skip
    dark = {name: style.after_dark(colour) for name, colour in colours.items()}
    write_html(
        path,
        "animation.html.j2",
        style.page_environment(),
        scene=scene,
        said=list(zip([one.label for one in scene.actors], said, strict=True)),
        data=_json(scene),
        schemes=(colours, dark),
    )


def _json(scene: Scene) -> str:
    """Data that the page's script draws, rounded to visible precision; safe inside a script."""
    moving = (np.column_stack((one.pose, one.velocity)) for one in scene.actors)
    content = {
        "names": [one.label for one in scene.actors],
        "rows": np.round(np.column_stack((scene.t, scene.target)), 4).tolist(),
        "robots": [np.round(table, 4).tolist() for table in moving],
        "view": [round(edge, 4) for edge in scene.view],
        "scales": [float(f"{scale:.4g}") for scale in scene.scales],
        "bands": [np.round(scene.band(one).T, 4).tolist() for one in scene.actors],
        "body": [scene.size * part for part in BODY],
        "wheel": [scene.size * part for part in WHEEL],
        "track": scene.size * TRACK,
        "waypoints": scene.course.waypoints,
        "goal": scene.course.goal,
        "keep_out": scene.course.keep_out,
        "dashes": [[] if isinstance(dash, str) else dash[1] for dash in style.DASHES],
    }
    return json.dumps(content, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


# -- the GIF -----------------------------------------------------------------------------------


def _write_gif(scene: Scene, path: Path, progress: Progress | None) -> None:
    """Write frames, all with the palette of the last one, which contains all elements."""
    images = []
    for picture in frames(scene):
        images.append(Image.fromarray(picture))
        if progress:
            progress(len(images) / len(scene.t))
    palette = images[-1].quantize(_GIF_COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    first, *others = (p.quantize(palette=palette, dither=Image.Dither.NONE) for p in images)
    first.save(
        path, save_all=True, append_images=others, duration=GIF_MILLISECONDS, loop=0, optimize=False
    )
