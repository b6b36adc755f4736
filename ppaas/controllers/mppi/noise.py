"""The variants of a sequence of commands that are tried each cycle."""

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.mppi.parameters import MppiParameters

MEMORY = 0.8
"""What of a deviation is left a step later: motors do not follow what flutters."""


def draw(parameters: MppiParameters) -> NDArray[np.float64]:
    """Return (batch_size, time_steps, 2) deviations [m/s, rad/s]; the first is none.

    For each there is one that turns the other way, so that the controller has no side that it prefers.
    """
    p = parameters
    half = (p.batch_size + 1) // 2
    white = np.random.default_rng(p.seed).standard_normal((half, p.time_steps, 2))
    deviations = white.copy()
    for step in range(1, p.time_steps):
        deviations[:, step] = MEMORY * deviations[:, step - 1] + np.sqrt(1.0 - MEMORY**2) * white[:, step]
    deviations *= (p.vx_std, p.wz_std)
    both = np.empty((2 * half, p.time_steps, 2))
    both[0::2] = deviations
    both[1::2] = deviations * (1.0, -1.0)
    both[0] = 0.0
    return both[: p.batch_size]
