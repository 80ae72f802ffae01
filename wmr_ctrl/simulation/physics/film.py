"""Three-dimensional pictures of a run on the rigid body, rendered by MuJoCo.

The log has the robot's position, not its full orientation, so the run is repeated from its seed,
and refused if the result differs.  OpenGL is chosen before MuJoCo is loaded: a separate process
renders, by EGL or OSMesa, or as MUJOCO_GL says.
"""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from wmr_ctrl.core.errors import ArgumentError, MissingExtraError, WmrError, install
from wmr_ctrl.results import Floats, Run
from wmr_ctrl.simulation.runnable import RunnableLoop

from .rigid import CHASSIS, description, mujoco
from .run import Coupling
from .workers import Worker

Picture: TypeAlias = NDArray[np.uint8]
HEIGHT, WIDTH = 480, 640
CHOICE, CHOICES = "MUJOCO_GL", ("egl", "osmesa")
_AT_A_TIME = 16
_DISTANCE, _AZIMUTH, _ELEVATION = 2.6, 60.0, -22.0
"""The camera's distance from the robot [m], its direction and its height [degrees]."""
_TRAIL, _GOAL = (0.10, 0.35, 0.75, 1.0), (0.85, 0.33, 0.10, 0.8)
_BAND = (0.85, 0.33, 0.10, 0.35)
_DOTS = 400
_POST = 0.45
"""Height [m] of the ball over the desired position, above the robot that hides the ground."""
_EMPTY = f"""<mujoco><worldbody><geom name="{CHASSIS}" size="1"/></worldbody></mujoco>"""


@dataclass(frozen=True)
class Moments:
    """Data of the frames of a run.

    ``model``: the robot as MJCF; ``rows`` (n,) of the log; ``positions`` (n, 9): MuJoCo's, the
    body's and the wheels'; ``target`` (n, 2): the desired position [m]; ``slip_max`` [m/s]: speed
    above which a tread slides; ``tube`` (n,) [m]: corridor about the path, nan without one.
    """

    model: str
    rows: NDArray[np.int64]
    positions: NDArray[np.float64]
    target: NDArray[np.float64]
    slip_max: float
    tube: NDArray[np.float64] | None = None


def moments_of(loop: RunnableLoop, run: Run, most: int) -> Moments:
    """Moments of a repeated run, at most ``most``, with the last sample.

    ``loop`` is that of the run's scenario and law.  Raises ArgumentError for a run without a
    sample, or one whose repetition differs.
    """
    if not run.rows:
        raise ArgumentError("the run has no sample to show: it ended before the first one.")
    coupling, positions = Coupling(loop, run.seed), list[NDArray[np.float64]]()
    while len(positions) < run.rows and not coupling.ended:
        positions.append(coupling.body.data.qpos.copy())
        coupling.sample()
    table = np.array(positions)
    if len(table) != run.rows or not np.array_equal(table[:, :2].T, (run["x"], run["y"])):
        raise ArgumentError(
            "simulated again on this machine, the run differs, and its log does not contain the "
            "orientation of the body. Make a new run on this machine with this version, and film "
            "that."
        )
    step = max(1, -(-run.rows // most))
    rows = np.unique(np.append(np.arange(0, run.rows, step), run.rows - 1))
    target = np.column_stack((run["x_d"], run["y_d"]))[rows]
    slides = loop.scenario.body.slip_max
    return Moments(description(loop.scenario), rows, table[rows], target, slides)


def pictures(moments: Moments) -> Iterator[Picture]:
    """The picture of each moment, (480, 640, 3); MissingExtraError if rendering is impossible."""
    worker = _painter()
    try:
        for first in range(0, len(moments.rows), _AT_A_TIME):
            seen = slice(first, first + _AT_A_TIME)
            ways = (moments.positions[:, :2], moments.target)
            shown = (moments.model, moments.positions[seen], *ways, first, moments.tube)
            yield from worker.ask(paint, shown)
    finally:
        worker.end()


def check_painter() -> None:
    """Raise MissingExtraError, with the remedy, if rendering is impossible."""
    mujoco()
    _painter().end()


def _painter() -> Worker:
    """A rendering process, with the first of EGL and OSMesa that works, or with MUJOCO_GL."""
    reasons = []
    for choice in [os.environ[CHOICE]] if os.environ.get(CHOICE) else CHOICES:
        worker = Worker({CHOICE: choice})
        try:
            worker.ask(paint, (_EMPTY, np.zeros((1, 0)), np.zeros((1, 2)), np.zeros((1, 2)), 0))
        except (WmrError, ImportError, AttributeError, RuntimeError, ValueError) as error:
            worker.end()
            reasons.append(f"{choice}: {str(error).splitlines()[0]}")
        else:
            return worker
    raise MissingExtraError(
        f"3-D pictures cannot be rendered here ({'; '.join(reasons)}). Install PyOpenGL "
        f"({install('physics')}), and EGL or OSMesa (apt install libegl1 libosmesa6), or set "
        f"{CHOICE} to what is available; --animate draws the run without any of these."
    )


def paint(
    model: str,
    positions: Floats,
    driven: Floats,
    target: Floats,
    first: int,
    tube: Floats | None = None,
) -> list[Picture]:
    """Pictures of some moments, numbered from ``first``; called in the rendering process."""
    stage, numbered = _scenery(model), enumerate(positions, first + 1)
    stage.lay(target, np.full(len(target), np.nan) if tube is None else tube)
    return [stage.picture(position, driven[:k], target[:k]) for k, position in numbered]


@lru_cache(maxsize=1)
def _scenery(model: str) -> "_Scenery":
    return _Scenery(model)


class _Scenery:
    """A model, a renderer and a camera that follows the robot."""

    def __init__(self, model: str) -> None:
        engine: Any = mujoco()
        self._engine = engine
        self._model = engine.MjModel.from_xml_string(model)
        self._data = engine.MjData(self._model)
        self._renderer = engine.Renderer(self._model, HEIGHT, WIDTH)
        self._camera = engine.MjvCamera()
        self._camera.distance, self._camera.azimuth = _DISTANCE, _AZIMUTH
        self._camera.elevation = _ELEVATION
        self._slabs: list[tuple[Floats, Floats, Floats]] = []

    def lay(self, path: Floats, widths: Floats) -> None:
        """Show a band within ``widths`` (n) [m] of a path (n, 2) on the ground from now on."""
        self._slabs, most = [], np.maximum(widths[:-1], widths[1:])
        for (one, other), width in zip(pairwise(path), most, strict=True):
            ahead = other - one
            long = float(np.hypot(*ahead))
            if width > 0 and long:
                a, b = ahead / long
                turned = np.array([a, -b, 0.0, b, a, 0.0, 0.0, 0.0, 1.0])
                size = np.array([long / 2, width, 0.001])
                self._slabs.append((size, np.array([*(one + other) / 2, 0.001]), turned))

    def picture(self, position: Floats, driven: Floats, target: Floats) -> Picture:
        """The robot, its path, the desired path, a post at the desired position, the band."""
        self._data.qpos[:] = position
        self._engine.mj_forward(self._model, self._data)
        self._camera.lookat[:] = (*driven[-1], 0.1)
        self._renderer.update_scene(self._data, self._camera)
        for way, colour in ((target, _GOAL), (driven, _TRAIL)):
            for point in way[:: -(-len(way) // _DOTS)]:
                self._dot(point, 0.012, colour)
        # A post with a ball on top.
        size, level = np.array([0.01, _POST / 2, 0.0]), np.eye(3).flatten()
        middle = np.array([*target[-1], _POST / 2])
        self._add(self._engine.mjtGeom.mjGEOM_CYLINDER, size, middle, level, _GOAL)
        self._dot(target[-1], 0.04, _GOAL, _POST)
        for slab in self._slabs:
            self._add(self._engine.mjtGeom.mjGEOM_BOX, *slab, _BAND)
        painted: Picture = self._renderer.render()
        return painted

    def _dot(
        self, point: NDArray[np.float64], size: float, colour: Sequence[float], up: float = 0.0
    ) -> None:
        """A ball on the ground, or above it [m]."""
        place, level = np.array([*point, size + up]), np.eye(3).flatten()
        ball = self._engine.mjtGeom.mjGEOM_SPHERE
        self._add(ball, np.full(3, size), place, level, colour)

    def _add(
        self, shape: int, size: Floats, place: Floats, turned: Floats, colour: Sequence[float]
    ) -> None:
        scene, tint = self._renderer.scene, np.array(colour, dtype=np.float32)
        self._engine.mjv_initGeom(scene.geoms[scene.ngeom], shape, size, place, turned, tint)
        scene.ngeom += 1
