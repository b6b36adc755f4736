"""Senses of a robot for docking: its scans, poses of docks that others detect, and where it is itself."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.docking.detection.base import NO_POINTS, DockView
from ppaas.docking.orders import Sight
from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.localization.beams import scan_points
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.frames import FrameListener, FrameNames, LateFrames
from ppaas.nodes.message_checks import finite_pose
from ppaas.nodes.robot_scans import ScanReader
from ppaas.transforms.planar import tf_time
from ppaas.transforms.spatial import Rigid

SILENT = 1.0
"""Age from which odometry and scans are missed [s]."""


class _Seen(NamedTuple):
    """Readings of a scan, or a detected pose, in the robot's frame, and the robot's odometry then."""

    odometry: Pose2D
    at: float
    points: NDArray[np.float64] = NO_POINTS
    intensities: NDArray[np.float64] | None = None
    detected: Rigid | None = None


class DockingSenses:
    """Keeps the newest of what the robot senses.

    Parameters
    ----------
    names : FrameNames, optional
        Names of the robot's frames.

    Attributes
    ----------
    lifted : bool or None
        Whether the lift is up; None as long as the robot does not report that.
    """

    def __init__(self, names: FrameNames | None = None) -> None:
        self._late = LateFrames(names)
        self._scans = ScanReader(self._late.now())
        self.lifted: bool | None = None
        self._scan: _Seen | None = None
        self._given: _Seen | None = None
        self._used: tuple[float, float] = (-math.inf, -math.inf)

    def hear(self, topic: str, message: TFMessage, now: float, stamp: float, *, at_once: bool) -> None:
        """Take transforms, at once or when they are needed; see `FrameListener.hear`."""
        if at_once:
            self.frames.hear(topic, message, now, stamp)
        else:
            self._late.keep(topic, message, now, stamp)

    @property
    def frames(self) -> FrameListener:
        """Frames of the robot."""
        return self._late.now()

    def take_scan(self, scan: LaserScan, now: float) -> None:
        """Take a scan.

        Raises
        ------
        InvalidInput
            It is not valid.
        TransformError
            The frame of its laser is unknown, or there is no odometry.
        """
        read = self._scans.read(scan, now)
        points = scan_points(read.scan, read.laser)
        self._scan = _Seen(self._odometry_at(tf_time(scan.header.stamp)), now, points, _intensities(read.scan))

    def take_pose(self, message: PoseStamped, now: float) -> None:
        """Take the pose of a dock that another detector has found; raises as `take_scan`."""
        frame = message.header.frame_id.lstrip("/")
        if not frame:
            raise InvalidInput("a detected dock pose needs header.frame_id, the frame of its pose")
        finite_pose(message.pose, "a detected dock")
        p, q = message.pose.position, message.pose.orientation
        norm = math.sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w)
        pose = Rigid(p.x, p.y, p.z, q.x / norm, q.y / norm, q.z / norm, q.w / norm)
        detected = self.frames.mount(frame, now) @ pose
        self._given = _Seen(self._odometry_at(tf_time(message.header.stamp)), now, detected=detected)

    def _odometry_at(self, stamp: float) -> Pose2D:
        """Return the robot's pose in the odometry frame at a time, or the newest if that is not known."""
        try:
            return self.frames.odometry(stamp or None)
        except TransformError:
            return self.frames.odometry()

    def odometry(self) -> Pose2D | None:
        """Return the pose of the robot in the odometry frame; None without odometry."""
        try:
            return self.frames.odometry()
        except TransformError:
            return None

    def robot_in_map(self) -> Pose2D | None:
        """Return the pose of the robot in the frame of the map; None as long as it is not localized."""
        try:
            return self.frames.in_map()
        except TransformError:
            return None

    def sight(self, now: float, held: str) -> Sight | None:
        """Return what the robot knows now, None without odometry.

        Parameters
        ----------
        now : float
            Time [s].
        held : str
            Why the robot must stand; empty if it may drive.
        """
        odometry = self.odometry()
        if odometry is None:
            return None
        robot = self.robot_in_map()
        in_odom = None if robot is None else odometry @ robot.inverse()
        view = self._view(odometry, now)
        return Sight(now, odometry, in_odom, view, held or self._silence(now), self.lifted)

    def _silence(self, now: float) -> str:
        if self.frames.odometry_silence(now) > SILENT:
            return "there is no odometry"
        return "there is no scan" if self._scan is not None and now - self._scan.at > SILENT else ""

    def _view(self, odometry: Pose2D, now: float) -> DockView | None:
        """Return what is new since the last call, seen from where the robot is now."""
        scan, given = self._scan, self._given
        times = (scan.at if scan else -math.inf, given.at if given else -math.inf)
        if times == self._used:
            return None
        is_new = times[1] > self._used[1]
        self._used = times
        points, intensities = NO_POINTS, None
        if scan is not None:
            moved = odometry.inverse() @ scan.odometry
            c, s = math.cos(moved.theta), math.sin(moved.theta)
            points, intensities = scan.points @ ((c, s), (-s, c)) + (moved.x, moved.y), scan.intensities
        detected = None
        if given is not None and given.detected is not None and is_new:
            detected = Rigid.planar(odometry.inverse() @ given.odometry) @ given.detected
        return DockView(points, intensities, detected)


def _intensities(scan: LaserScan) -> NDArray[np.float64] | None:
    """Return the intensities of the beams with a reading, in the order of `scan_points`; None if there are none."""
    if len(scan.intensities) != len(scan.ranges):
        return None
    ranges = np.array(scan.ranges, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        hits = (ranges > max(scan.range_min, 0.0)) & (ranges < scan.range_max)
    return np.nan_to_num(np.array(scan.intensities, dtype=np.float64)[hits])
