"""The path of a scenario as C99: the desired motion at any time."""

import numpy as np

from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.core.signals import TIME
from wmr_ctrl.world.model.system import System
from wmr_ctrl.world.references.kind import reference
from wmr_ctrl.world.scenario import Scenario

from .dialect import HEADER
from .emit import kernel
from .layouts import arranged
from .package import TEMPLATES, shared_context, text_engine
from .resources import c_texts
from .vectors import TOLERANCES, Floats

FILES = ("wmr_reference.h", "wmr_reference.c", "reference_vectors.h", "reference_check.c",
         "README_reference.md")  # fmt: skip
EARLY, LATE = (-1e3, -1e-3), (1.517, 3.143, 9.871)
"""Times before the start [s], and beyond the end as multiples of it."""


def reference_files(
    scenario: Scenario, *, float32: bool = False, layout: str | None = None
) -> dict[str, str]:
    """File name to text of the package of a scenario's path; ``layout`` as in `package_files`.

    ArgumentError for a reference of another package that is not a function of time alone.
    """
    system, kind = reference(scenario), scenario.reference_kind.name
    if system.state or [item.signal for item in system.inputs] != [TIME]:
        raise ArgumentError(
            f'reference.kind = "{kind}": its graph has a memory or counts samples, and C '
            "is written only of references that are functions of time. Export the FMU `reference`."
        )
    path = kernel("path", "The desired motion.", {"u": system.u, "p": system.p}, {"y": system.y})
    context = shared_context("reference", scenario, system, path, float32)
    vectors, tolerance = _vectors(scenario, system, float32, context["largest"])
    context |= {"layout": layout, "sends": False, "vectors": vectors, "tolerance": tolerance}
    engine = text_engine(TEMPLATES)
    files = {name: engine.get_template(f"{name}.j2").render(context) for name in FILES}
    files |= {} if float32 else c_texts(HEADER)
    return files if layout is None else arranged(files, layout, engine, context)


def _vectors(
    scenario: Scenario, system: System, float32: bool, largest: float
) -> tuple[list[tuple[float, Floats]], float]:
    """Times with the motion that CasADi's virtual machine computes, and the largest error."""
    real, end = np.float32 if float32 else np.float64, scenario.reference.arrival
    end = scenario.clock.duration if end is None else end
    shares = (0, *(np.arange(40) + 0.37) / 40, *LATE)  # none at the end of a lap, where floats jump
    times = np.array([*EARLY, *(end * share for share in shares)]).astype(real).astype(float)
    numbers = np.array(system.p0).astype(real).astype(float)
    graph = system.function("reference", [system.y])
    motion = np.array([graph(max(t, 0.0), [], numbers).full().ravel() for t in times])
    drift = 4 * float(np.finfo(real).eps) * times.max() * np.abs(motion[:, 3:5]).max()
    known = np.isfinite(motion).all(axis=1) & (times <= largest)
    rows = list(zip(times[known].tolist(), motion[known], strict=True))
    return rows, TOLERANCES[float32] + drift
