"""The robot on its path with its reference as a ghost, as a page, a GIF or a film."""

from __future__ import annotations

import os
from pathlib import Path

from wmr_ctrl.campaign import Progress, Silent
from wmr_ctrl.errors import ResultFileError
from wmr_ctrl.report.animation import film, gif, page
from wmr_ctrl.report.animation.scene import scene_of
from wmr_ctrl.results import Run, atomic_path, check_writable

SUFFIXES = (".gif", ".mp4", ".html")
_FRAMES = {".gif": gif.FRAMES, ".mp4": film.FRAMES, ".html": page.FRAMES}


def animate_run(run: Run, path: str | os.PathLike[str], progress: Progress | None = None) -> None:
    """Animate ``run`` into a .html (crisp, with play and slider), .gif or .mp4 file.

    The file is written whole or not at all.  Raises ResultFileError for another suffix or where
    the file cannot be written, MissingExtraError for .mp4 without ffmpeg, ArgumentError for a run
    without any sample.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in SUFFIXES:
        raise ResultFileError(
            f"{str(target)!r} has the suffix {target.suffix!r}; a run is animated as "
            f"{', '.join(SUFFIXES)}. Give the file one of these suffixes."
        )
    check_writable(target)
    if suffix == ".mp4":
        film.find_ffmpeg()
    _animate(run, target, suffix, progress or Silent())


def _animate(run: Run, target: Path, suffix: str, progress: Progress) -> None:
    scene = scene_of(run, _FRAMES[suffix])
    progress.start(len(scene.t), "Drawing the animation")
    try:
        with atomic_path(target) as scratch:
            if suffix == ".gif":
                gif.write_gif(scene, scratch, progress)
            elif suffix == ".mp4":
                film.write_film(scene, scratch, progress)
            else:
                page.write_page(scene, scratch)
                progress.advance(len(scene.t))
    finally:
        progress.done()
