"""Frames of the live page in a headless browser: ``python -m benchmarks.page [PAGE.html]``.

Four laws drive at once, for a few seconds at 1 and at 10 times the clock's speed. It reports
frames per second, and the script's time per frame: simulation, picture and charts, without the
browser's own work.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

from .browser import CHROMIUM, browser

SECONDS = 5.0
LAWS = ("pid", "mb", "nn", "prox")
READY = "window.wmr && window.wmr.page && window.wmr.page.frames > 1"
MEASURE = """(async () => {
  const { page } = wmr, own = page.frame.bind(page), times = [];
  const timed = (now) => { const t = performance.now(); own(now); return performance.now() - t; };
  page.frame = (now) => times.push(timed(now));
  page.play(true);
  await new Promise((done) => setTimeout(done, 500));
  times.length = 0;
  const begun = performance.now();
  await new Promise((done) => setTimeout(done, %f));
  const seconds = (performance.now() - begun) / 1000;
  const sorted = [...times].sort((a, b) => a - b);
  return {
    rate: times.length / seconds, middle: sorted[times.length >> 1],
    most: sorted[Math.floor(0.95 * times.length)],
  };
})()"""


def measured(page: Path, link: str) -> dict[str, Any]:
    """Frames a second, and median and 95 % quantile of the script's time in a frame [ms]."""
    program = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if program is None:
        raise SystemExit(f"None of these is installed: {', '.join(CHROMIUM)}")
    with tempfile.TemporaryDirectory() as folder, browser(program, Path(folder)) as one:
        one.show(1300, 900)
        one.open(f"{page.as_uri()}#{link}", READY)
        found: dict[str, Any] = one.value(MEASURE % (1000 * SECONDS))
        return found


def main(arguments: list[str]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        if arguments:
            page = Path(arguments[0]).resolve()
        else:
            from wmr_ctrl import write_page

            page = write_page(Path(folder) / "page.html", laws=LAWS)
        for speed in (1, 10):
            said = measured(page, f"laws={'.'.join(LAWS)}&speed={speed}")
            print(
                f"{len(LAWS)} laws at {speed}x: {said['rate']:.0f} frames/s, script "
                f"{said['middle']:.2f} ms in a frame (95 %: below {said['most']:.2f} ms)"
            )


if __name__ == "__main__":
    main(sys.argv[1:])
