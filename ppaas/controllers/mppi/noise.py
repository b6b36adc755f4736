"""Random deviations of the command sequences that are tried in each cycle."""

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.mppi.parameters import MppiParameters

MEMORY = 0.8
"""Correlation of successive deviations, since motors cannot follow white noise."""


def draw(parameters: MppiParameters) -> NDArray[np.float64]:
    """Return deviations (batch_size, time_steps, 2) of forward and turning speed [m/s, rad/s]; the first is zero.

    Each deviation has a mirror image that turns the other way, so that the controller prefers no side.
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
