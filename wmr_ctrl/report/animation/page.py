"""The scene as a page with a canvas, a slider and a play button; it needs nothing but itself."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from wmr_ctrl.report.animation.scene import BODY, TRACK, WHEEL, Scene
from wmr_ctrl.report.style import LIMIT, MUTED, look

FRAMES = 2000


def write_page(scene: Scene, path: Path) -> None:
    """Write the page."""
    environment = Environment(
        loader=PackageLoader("wmr_ctrl.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
    )
    run = scene.run
    text = environment.get_template("animation.html.j2").render(
        title=f"{look(run.law).label}, {run.scenario}, seed {run.seed}",
        explanation=run.explanation,
        data=_json(scene),
    )
    path.write_text(text, encoding="utf-8", newline="\n")


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
        "colours": {"law": look(scene.run.law).colour, "muted": MUTED, "limit": LIMIT},
    }
    return json.dumps(content, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
