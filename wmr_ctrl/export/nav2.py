"""Parameters of nav2 that a base's delay and accelerations limit."""

import math
from pathlib import Path

from wmr_ctrl.codegen.package import text_engine
from wmr_ctrl.core.errors import ArgumentError
from wmr_ctrl.identification import BaseIdentification
from wmr_ctrl.identification.bounds import DETERMINED, ROUGHLY


def nav2_of(result: BaseIdentification) -> str:
    """YAML text for nav2's MPPI controller and its velocity smoother.

    Values that the log does not show are comments.  Raises ArgumentError for a base that takes
    torques.
    """
    if result.bounds.section != "filter":
        raise ArgumentError(
            f"{result.name}: nav2 sends velocities, and this base takes torques. Identify it with "
            "--base velocity, from a log of v_command and omega_command."
        )
    values = {name: item.value for name, item in result.parameters.items()
              if item.verdict in (DETERMINED, ROUGHLY)}  # fmt: skip
    up = [values.get(f"accel{axis}", math.inf) for axis in (1, 2)]
    down = [values.get(f"decel{axis}", most) for axis, most in zip((1, 2), up, strict=True)]
    late = max(values.get(f"delay{axis}", math.inf) for axis in (1, 2))
    slow = [values.get(f"dead{axis}", 0 * values.get(f"gain{axis}", math.inf)) for axis in (1, 2)]
    engine = text_engine(Path(__file__).parent / "templates")
    return engine.get_template("nav2.yaml.j2").render(
        name=result.name, row=_row, up=up, down=down, late=late, slow=slow
    )


def _row(name: str, *values: float) -> str:
    if not all(map(math.isfinite, values)):
        return f"# {name}: the log shows none"
    shown = [float(f"{value:.4g}") for value in values]
    return f"{name}: {shown if len(shown) > 1 else shown[0]}"
