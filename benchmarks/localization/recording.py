"""Recordings of a robot: odometry, scans, and true poses if they are known."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.messages.sensor_msgs import LaserScan


@dataclass(frozen=True, slots=True)
class RecordedFrames:
    """Topic and frames to read from a bag; None takes the names from the bag itself.

    Parameters
    ----------
    scan_topic : str, optional
        Topic of the scans to use; all scans by default.
    odom, base : str, optional
        Frames of the odometry and of the robot.
    map : str, optional
        Frame of the true poses.
    """

    scan_topic: str | None = None
    odom: str | None = None
    base: str | None = None
    map: str | None = None


@dataclass(frozen=True, slots=True)
class Look:
    """A scan with its poses.

    Parameters
    ----------
    stamp : float
        Time of the scan [s], not before that of the one before.
    odom : Pose2D
        Pose of the robot in the odometry frame.
    scan : LaserScan
        As a level laser sends it.
    true : Pose2D or None
        True pose of the robot in the map frame, if it is known.
    laser : Pose2D
        Pose of the laser in the robot's frame [m, rad].
    """

    stamp: float
    odom: Pose2D
    scan: LaserScan
    true: Pose2D | None
    laser: Pose2D = Pose2D(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Recording:
    """A recorded drive.

    Parameters
    ----------
    looks : tuple of Look
        At least one scan.
    """

    looks: tuple[Look, ...]


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
