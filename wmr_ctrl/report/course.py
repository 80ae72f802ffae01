"""Parts of a run's map besides the path: waypoints, goal, obstacles, the robot's size, tube.

The tube is the certified corridor of the run's scenario and law, as a band about the path.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle as CirclePatch
from matplotlib.patches import Patch, Polygon

from wmr_ctrl.control.laws.registry import LAWS
from wmr_ctrl.results import Floats, Run
from wmr_ctrl.results.obstacles import Shape
from wmr_ctrl.theory.checks.outlook import scenario_of_run
from wmr_ctrl.theory.corridor import corridor_course, is_covered
from wmr_ctrl.world.references import Waypoints
from wmr_ctrl.world.scenario import Scenario, override

from .style import GRID, INK, LIMIT, MUTED

WITHIN = 0.53
"""Half track of a robot drawn within its body's circle, as a share of the circle's radius."""
MOST_WAYPOINTS = 60
"""Most waypoints that are drawn; more would hide their path."""


@dataclass(frozen=True)
class Course:
    """Waypoints and goal [m], obstacles, half the robot's track, and its body's radius [m]."""

    waypoints: tuple[tuple[float, float], ...] = ()
    goal: tuple[float, float] | None = None
    keep_out: tuple[Shape, ...] = ()
    half_track: float | None = None
    radius: float | None = None

    def draw(self, axes: Axes) -> list[str]:
        """Draw it on a map; returns the legend of its marks."""
        marks = []
        if self.waypoints:
            axes.plot(*np.array(self.waypoints).T, "s", mfc="none", mec=INK, ms=6, mew=0.8,
                      zorder=3.6)  # fmt: skip
            marks.append("squares: points")
        for shape in self.keep_out:
            axes.add_patch(_obstacle(shape))
        if self.goal:
            axes.plot(*self.goal, "*", mfc=LIMIT, mec="white", ms=11, zorder=4)
            marks.append("star: goal")
        return marks

    def draw_end(self, axes: Axes, run: Run, colour: str) -> bool:
        """Draw the body where a run among obstacles ends; False where there are none."""
        if self.radius is None or not self.keep_out:
            return False
        end = run["x"][-1], run["y"][-1]
        axes.add_patch(CirclePatch(end, self.radius, fill=False, ec=colour, lw=1.2, zorder=3.7))
        return True


def course_of(run: Run) -> Course:
    """The course of a run, as far as its scenario is known."""
    scenario, goal = scenario_of_run(run), None
    if run.settings.arrival is not None and run.settings.arrival <= run.time[-1]:
        goal = float(run["x_d"][-1]), float(run["y_d"][-1])
    if scenario is None:
        return Course(goal=goal)
    reference = scenario.reference
    points = reference.points if isinstance(reference, Waypoints) else ()
    shown = points if len(points) <= MOST_WAYPOINTS else ()
    waypoints = tuple((float(x), float(y)) for x, y in shown)
    half_track, radius = drawn_half_track(scenario), scenario.body.radius
    return Course(waypoints, goal, scenario.obstacles, half_track, radius)


def drawn_half_track(scenario: Scenario) -> float:
    """Half the track [m], or less if a body of body.radius has no room for the drawing."""
    radius = scenario.body.radius
    return scenario.robot.l if radius is None else min(scenario.robot.l, WITHIN * radius)


def _obstacle(shape: Shape) -> Patch:
    """An obstacle: a hatched polygon or circle, or a wall."""
    if isinstance(shape[0], tuple):
        patch: Patch = Polygon(np.array(shape))
    else:
        patch = CirclePatch((shape[0], shape[1]), shape[2])
    width = 2.5 if len(shape) == 2 else 0.8
    patch.set(facecolor=GRID, edgecolor=MUTED, hatch="////", linewidth=width, zorder=1.5)
    return patch


FAINT = 0.25
"""Opacity of a band."""


def course_of_tube(run: Run) -> Floats | None:
    """Certified distance [m] and heading [rad] (2, rows) over the run's time; None without.

    None also for the rigid body and foreign plants: the certificate is about the plane model.
    """
    return course_behind(run) if is_covered(run) else None


def course_behind(run: Run) -> Floats | None:
    """Certified distance and heading for any plant of the run; nan where nothing is certified.

    If one corridor is not valid for the whole run, for example after a change of the robot, each
    sample has its own, that of the whole run.
    """
    scenario = scenario_of_run(run)
    if scenario is None or run.law not in LAWS:
        return None
    tube = corridor_course(override(scenario, {"guard.enabled": run.guard}), run.law)
    if tube is None or tube.course is None:
        return None
    course = tube.course[:, np.minimum(np.arange(run.rows), tube.course.shape[1] - 1)]
    if tube.until is not None:
        course[:, run.settings.index(tube.until) :] = np.nan
    return course


def band(path: Floats, width: Floats) -> Floats:
    """Corners (2, 2m) of the band within ``width`` [m] (n) of a path (2, n), up to its first nan.

    At points where the path does not move, the largest of their widths is used.
    """
    held = np.isfinite(width)
    path, width = path[:, held], width[held]
    moved = np.flatnonzero(np.any(np.diff(path, axis=1), axis=0)) + 1
    if not moved.size:
        return np.empty((2, 0))
    begun = np.append(0, moved)
    path, width = path[:, begun], np.maximum.reduceat(width, begun)
    ahead = np.gradient(path, axis=1)
    step = np.maximum(np.hypot(*ahead), np.finfo(float).tiny)
    side = width * np.array((-ahead[1], ahead[0])) / step
    return np.hstack([path + side, (path - side)[:, ::-1]])
