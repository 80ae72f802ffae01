"""The robot on its path with its reference as a ghost, as a page, a GIF or a film."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import IO

import numpy as np
from PIL import Image

from wmr_ctrl.campaign import PhaseProgress, Silent
from wmr_ctrl.errors import MissingExtraError, ResultFileError
from wmr_ctrl.report.scene import BODY, FRAME, TRACK, WHEEL, Picture, Scene, frames, scene_of
from wmr_ctrl.report.style import AFTER_DARK, INK, LIMIT, MUTED, PAPER, RULE_LINE, driver, look
from wmr_ctrl.report.web import page_environment
from wmr_ctrl.results import Run, atomic_path, check_writable

SUFFIXES = (".gif", ".mp4", ".html")
_FRAMES = {".gif": 250, ".mp4": 600, ".html": 2000}
"""At most as many frames are shown."""

GIF_MILLISECONDS = 80
"""Time that a frame of a GIF is shown; whole runs thus take 20 s."""

FILM_RATE = 30
"""Frames of a film per second; whole runs thus take 20 s."""

_GIF_COLOURS = 48


def animate_run(
    run: Run, path: str | os.PathLike[str], progress: PhaseProgress | None = None
) -> None:
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
        find_ffmpeg()
    _animate(run, target, suffix, progress or Silent())


def _animate(run: Run, target: Path, suffix: str, progress: PhaseProgress) -> None:
    scene = scene_of(run, _FRAMES[suffix])
    progress.start(len(scene.t), "Drawing the animation")
    try:
        with atomic_path(target) as scratch:
            if suffix == ".gif":
                write_gif(frames(scene), scratch, progress)
            elif suffix == ".mp4":
                write_film(frames(scene), FRAME, scratch, progress)
            else:
                write_page(scene, scratch)
                progress.advance(len(scene.t))
    finally:
        progress.done()


def write_page(scene: Scene, path: Path) -> None:
    """Write the page."""
    run = scene.run
    text = (
        page_environment()
        .get_template("animation.html.j2")
        .render(
            title=f"{driver(run.law, run.guard)}, {run.scenario}, seed {run.seed}",
            explanation=run.explanation,
            data=_json(scene),
            light=_colours(run.law, dark=False),
            dark=_colours(run.law, dark=True),
        )
    )
    path.write_text(text, encoding="utf-8", newline="\n")


def _colours(law: str, *, dark: bool) -> str:
    """Colours of the drawing as the names that the style and the script know."""
    named = {"law": look(law).colour, "muted": MUTED, "limit": LIMIT,
             "ink": INK, "paper": PAPER, "line": RULE_LINE}  # fmt: skip
    return " ".join(
        f"--{name}: {AFTER_DARK.get(colour, colour) if dark else colour};"
        for name, colour in named.items()
    )


def _json(scene: Scene) -> str:
    """Everything that the script draws, rounded to what can be seen; safe inside a script."""
    table = np.column_stack((scene.t, scene.pose, scene.target, scene.velocity))
    content = {
        "rows": np.round(table, 4).tolist(),
        "view": [round(edge, 4) for edge in scene.view],
        "limits": scene.limits,
        "body": BODY,
        "wheel": WHEEL,
        "track": TRACK,
    }
    return json.dumps(content, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def write_gif(shown: Iterable[Picture], path: Path, progress: PhaseProgress) -> None:
    """Write frames, all in the palette of the last one, which shows everything."""
    pictures = []
    for picture in shown:
        pictures.append(Image.fromarray(picture))
        progress.advance(1)
    palette = pictures[-1].quantize(
        _GIF_COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE
    )
    first, *others = (p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures)
    first.save(
        path, save_all=True, append_images=others, duration=GIF_MILLISECONDS, loop=0, optimize=False
    )


def find_ffmpeg() -> str:
    """The ffmpeg program; raises MissingExtraError with the remedy where there is none."""
    program = shutil.which("ffmpeg")
    if program is None:
        raise MissingExtraError(
            "films need the program ffmpeg, which was not found on the PATH. Install it "
            "(apt install ffmpeg, brew install ffmpeg, winget install ffmpeg), or choose .html "
            "or .gif, which need nothing."
        )
    return program


def write_film(
    shown: Iterable[Picture], size: tuple[int, int], path: Path, progress: PhaseProgress
) -> None:
    """Write frames of ``size`` (width, height) as a film; ResultFileError where ffmpeg fails."""
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(_command(path, size), stdin=subprocess.PIPE, stderr=errors)
        assert process.stdin is not None
        broken = _feed(shown, process.stdin, progress)
        if process.wait() or broken:
            errors.seek(0)
            lines = errors.read().decode(errors="replace").strip().splitlines()
            raise ResultFileError(
                f"ffmpeg could not write the film: {lines[-1] if lines else 'no reason given'}. "
                "Choose .html or .gif instead."
            )


def _command(path: Path, size: tuple[int, int]) -> list[str]:
    kind = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", "{}x{}".format(*size))
    raw = (*kind, "-r", str(FILM_RATE), "-i", "-")
    coding = ("-an", "-pix_fmt", "yuv420p", "-movflags", "+faststart")
    return [find_ffmpeg(), "-loglevel", "error", "-y", *raw, *coding, str(path)]


def _feed(shown: Iterable[Picture], pipe: IO[bytes], progress: PhaseProgress) -> bool:
    """Hand over all frames; whether the other side closed the pipe before the end."""
    try:
        with pipe:
            for picture in shown:
                pipe.write(picture.tobytes())
                progress.advance(1)
    except BrokenPipeError:
        return True
    return False
