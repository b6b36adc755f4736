"""Noise that is added to the odometry of a recording."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ppaas.geometry import Pose2D
from robots.recordings.recording import Recording


def drifting(recording: Recording, drift: float, seed: int) -> Recording:
    """Return the same drive with noise added to the odometry.

    Parameters
    ----------
    recording : Recording
    drift : float
        Standard deviation of the noise of each motion, relative to its length and its turn. The turn gets additional
        noise of a tenth of ``drift`` for each metre [rad].
    seed : int
        Seed of the noise.
    """
    random = np.random.default_rng(seed)
    looks = list(recording.looks[:1])
    for before, after in pairwise(recording.looks):
        motion = before.odom.inverse() @ after.odom
        longer, turned, aside = (drift * random.standard_normal(3)).tolist()
        turn = motion.theta * turned + 0.1 * aside * math.hypot(motion.x, motion.y)
        moved = Pose2D(motion.x * (1.0 + longer), motion.y * (1.0 + longer), motion.theta + turn)
        looks.append(replace(after, odom=looks[-1].odom @ moved))
    return replace(recording, looks=tuple(looks))
