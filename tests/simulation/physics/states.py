"""All that the next steps of a rigid body depend on, but for changed parameters."""

from __future__ import annotations

import mujoco
import numpy as np

from wmr_ctrl.simulation.physics.rigid import RigidBody

KIND = mujoco.mjtState.mjSTATE_INTEGRATION


def state_of(body: RigidBody) -> np.ndarray:
    """MuJoCo's state, as it resumes to the bit."""
    whole = np.empty(mujoco.mj_stateSize(body.model, KIND))
    mujoco.mj_getState(body.model, body.data, whole, KIND)
    return whole
