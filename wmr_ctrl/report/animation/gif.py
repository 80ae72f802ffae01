"""Frames as an animated GIF."""

from __future__ import annotations

from pathlib import Path

from PIL import Image

from wmr_ctrl.campaign import Progress
from wmr_ctrl.report.animation.painter import frames
from wmr_ctrl.report.animation.scene import Scene

FRAMES = 250
MILLISECONDS = 80
"""Time that a frame is shown; whole runs thus take 20 s."""

_COLOURS = 48


def write_gif(scene: Scene, path: Path, progress: Progress) -> None:
    """Write the scene's frames, all in the palette of the last one, which shows everything."""
    pictures = []
    for picture in frames(scene):
        pictures.append(Image.fromarray(picture))
        progress.advance(1)
    palette = pictures[-1].quantize(_COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    first, *others = (p.quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures)
    first.save(
        path, save_all=True, append_images=others, duration=MILLISECONDS, loop=0, optimize=False
    )
