"""Frames as an MP4 film, by ffmpeg."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import IO

from wmr_ctrl.campaign import Progress
from wmr_ctrl.errors import MissingExtraError, ResultFileError
from wmr_ctrl.report.animation.painter import frames
from wmr_ctrl.report.animation.scene import Scene

FRAMES = 600
RATE = 30
"""Frames per second; whole runs thus take 20 s."""


def find_ffmpeg() -> str:
    """The ffmpeg program; raises MissingExtraError with the remedy where there is none."""
    found = shutil.which("ffmpeg")
    if found is None:
        raise MissingExtraError(
            "films need the program ffmpeg, which was not found on the PATH. Install it "
            "(apt install ffmpeg, brew install ffmpeg, winget install ffmpeg), or choose .html "
            "or .gif, which need nothing."
        )
    return found


def write_film(scene: Scene, path: Path, progress: Progress) -> None:
    """Write the scene's frames as a film; raises ResultFileError where ffmpeg fails."""
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(_command(path), stdin=subprocess.PIPE, stderr=errors)
        assert process.stdin is not None
        broken = _feed(scene, process.stdin, progress)
        if process.wait() or broken:
            errors.seek(0)
            told = errors.read().decode(errors="replace").strip().splitlines()
            raise ResultFileError(
                f"ffmpeg could not write the film: {told[-1] if told else 'no reason given'}. "
                "Choose .html or .gif instead."
            )


def _command(path: Path) -> list[str]:
    raw = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", "560x620", "-r", str(RATE), "-i", "-")
    coding = ("-an", "-pix_fmt", "yuv420p", "-movflags", "+faststart")
    return [find_ffmpeg(), "-loglevel", "error", "-y", *raw, *coding, str(path)]


def _feed(scene: Scene, pipe: IO[bytes], progress: Progress) -> bool:
    """Hand over all frames; whether the other side closed the pipe before the end."""
    try:
        with pipe:
            for picture in frames(scene):
                pipe.write(picture.tobytes())
                progress.advance(1)
    except BrokenPipeError:
        return True
    return False
