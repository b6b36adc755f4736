"""What a robot recorded: its odometry, its scans, and where it truly was, if somebody found that out later."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.messages.sensor_msgs import LaserScan


@dataclass(frozen=True, slots=True)
class Look:
    """One scan.

    Parameters
    ----------
    stamp : float
        Seconds, later than that of the look before.
    odom : Pose2D
        Of the robot in the odometry frame.
    scan : LaserScan
    true : Pose2D or None
        Of the robot in the map frame.
    """

    stamp: float
    odom: Pose2D
    scan: LaserScan
    true: Pose2D | None


@dataclass(frozen=True, slots=True)
class Recording:
    """A drive.

    Parameters
    ----------
    looks : tuple of Look
        One at least.
    laser : Pose2D
        Of the laser in the robot's frame [m, rad].
    """

    looks: tuple[Look, ...]
    laser: Pose2D


def drifting(recording: Recording, drift: float, seed: int) -> Recording:
    """Return the same drive with odometry that is worse.

    Parameters
    ----------
    recording : Recording
    drift : float
        Standard deviation of what is added to each motion, as part of it: of its length, and of its turn, to which a
        tenth of it for each metre is added [rad].
    seed : int
        The same seed drifts in the same way.
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
