"""A run on the rigid body as a film in three dimensions, with its figures below the picture."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from wmr_ctrl.campaign import PhaseProgress, Silent
from wmr_ctrl.errors import ArgumentError, ResultFileError
from wmr_ctrl.physics.film import HEIGHT, WIDTH, Moments, check_painter, pictures
from wmr_ctrl.report.animate import find_ffmpeg, write_film, write_gif
from wmr_ctrl.report.scene import Picture
from wmr_ctrl.report.style import INK, LIMIT, driver
from wmr_ctrl.results import Run, atomic_path, check_writable

FILMS = (".mp4", ".gif")
MOST_MOMENTS = {".mp4": 360, ".gif": 120}
"""At most as many pictures; each takes tenths of a second where there is no graphics card."""
_STRIP = 60
"""Height of the strip below the picture [pixels]."""
_LEFT = (10, 135, 290, 500)
"""Where its figures begin [pixels]."""


def check_film(path: str | os.PathLike[str], plant: str) -> None:
    """Raise, before anything is computed, where a run on ``plant`` cannot be filmed there.

    ArgumentError for the plane model, ResultFileError for the file, MissingExtraError without
    OpenGL, or ffmpeg for .mp4.
    """
    target = Path(path)
    if target.suffix.lower() not in FILMS:
        raise ResultFileError(
            f"{str(target)!r} has the suffix {target.suffix!r}; a film is {' or '.join(FILMS)}. "
            "Give the file one of these suffixes."
        )
    if plant != "mujoco":
        raise ArgumentError(
            "a film shows the rigid body, and the run is of the plane model. Take the plant mujoco "
            "(--plant mujoco), or draw the run (--animate)."
        )
    check_writable(target)
    if target.suffix.lower() == ".mp4":
        find_ffmpeg()
    check_painter()


def write_moments(
    run: Run,
    moments: Moments,
    path: str | os.PathLike[str],
    progress: PhaseProgress | None = None,
) -> None:
    """Write the film of a run, whole or not at all; errors as `Run.film` says."""
    target, shown = Path(path), progress or Silent()
    shown.start(len(moments.rows), "Painting the film")
    try:
        with atomic_path(target) as scratch:
            frames = _captioned(run, moments)
            if target.suffix.lower() == ".gif":
                write_gif(frames, scratch, shown)
            else:
                write_film(frames, (WIDTH, HEIGHT + _STRIP), scratch, shown)
    finally:
        shown.done()


def _captioned(run: Run, moments: Moments) -> Iterator[Picture]:
    for row, picture in zip(moments.rows.tolist(), pictures(moments), strict=True):
        whole = Image.new("RGB", (WIDTH, HEIGHT + _STRIP), "white")
        whole.paste(Image.fromarray(picture))
        _write(ImageDraw.Draw(whole), run, row, moments.slip_max)
        yield np.asarray(whole)


def _write(draw: ImageDraw.ImageDraw, run: Run, row: int, slip_max: float) -> None:
    """The figures of a row; red beyond a limit."""
    font = ImageFont.load_default(15)
    title = f"{driver(run.law, run.guard)}, {run.scenario}, seed {run.seed}, on tyres"
    draw.text((10, HEIGHT + 8), title, INK, font)
    draw.text((WIDTH - 100, HEIGHT + 8), f"t = {run.time[row]:.2f} s", INK, font)
    v, slip = (run["v1"][row], run["omega"][row]), np.abs(run["slip"][row]).max()
    beyond = [abs(x) > limit for x, limit in zip(v, run.settings.v_u1, strict=True)]
    texts = (
        (f"v1 {v[0]:+.2f} m/s", beyond[0]),
        (f"omega {v[1]:+.2f} rad/s", beyond[1]),
        (f"tread slides {slip:.2f} m/s", slip > slip_max),
        (f"leans {math.degrees(run['tilt'][row]):.0f} degrees", False),
    )
    for left, (text, bad) in zip(_LEFT, texts, strict=True):
        draw.text((left, HEIGHT + 32), text, LIMIT if bad else INK, font)
