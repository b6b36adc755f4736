"""Recordings of a robot: odometry, scans, and true poses if they are known."""

from dataclasses import dataclass

from ppaas.geometry import Pose2D
from ppaas.messages.sensor_msgs import LaserScan

NO_ODOMETRY = (
    "there is no odometry: the robot's motion is found by the scans alone, up to 0.25 m and 0.25 rad from one to the "
    "next, and not along bare corridors"
)
"""Note on a recording whose scans are all that is known of the motion."""


@dataclass(frozen=True, slots=True)
class RecordedFrames:
    """Topic and frames to read from a bag; None takes the names from the bag itself.

    Parameters
    ----------
    scan_topic : str, optional
        Topic of the scans to use, or in a log of CARMEN the name of their messages; all scans of a bag, and those of
        the front laser of a log, by default.
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
        Time of the scan [s], not before the time of the one before.
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
    notes : tuple of str
        What was left out, or is missing.
    has_odometry : bool
        Whether the poses in the odometry frame are measured; without it, they are zero.
    """

    looks: tuple[Look, ...]
    notes: tuple[str, ...] = ()
    has_odometry: bool = True
