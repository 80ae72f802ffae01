"""All that the next steps of a rigid body depend on, but for changed parameters."""

import mujoco
import numpy as np

KIND = mujoco.mjtState.mjSTATE_INTEGRATION


def state_of(body):
    """MuJoCo's state, as it resumes to the bit."""
    whole = np.empty(mujoco.mj_stateSize(body.model, KIND))
    mujoco.mj_getState(body.model, body.data, whole, KIND)
    return whole
