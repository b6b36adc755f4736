"""Other robots in the frame of a published map that is continued, or of a joint map: they are not mapped."""

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.geometry import Pose2D
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.scan_points import ScanPoints, without_discs
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.nodes.base import Payload
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import expect
from ppaas.nodes.other_robots import OTHERS_FRESH, others_of

RADIUS = 0.3
"""Radius of robots that do not report one [m]."""

SAME = 1e-6
"""Difference of the coordinates of equal poses [m, rad]."""


class OtherRobots:
    """Positions of other robots. They hold only while the map has the first key frame of the map in common.

    A robot that starts a separate map, by ``clear`` or another pose graph, is in a frame that the others do not know.

    Attributes
    ----------
    frame : str
        Name of the frame for the other robots: ``map`` on a published map, or the name of a joint map's frame.
    """

    def __init__(self) -> None:
        self.frame = MAP
        self._heard: tuple[float, tuple[MovingObstacle, ...]] = float("-inf"), ()
        self._first: tuple[NDArray[np.float32], NDArray[np.float64]] | None = None

    def use_frame_of(self, common: KeyFrames, frame: str = MAP) -> None:
        """Compare maps with this one from now on; positions that were heard before are forgotten."""
        self._first = common.points[0].copy(), common.poses[0].copy()
        if frame != self.frame:
            self.frame, self._heard = frame, (float("-inf"), ())

    def are_in(self, frames: KeyFrames) -> bool:
        """Return whether the poses of other robots are in the frame of a map."""
        if self._first is None or not len(frames):
            return False
        scan, pose = self._first
        return np.array_equal(frames.points[0], scan) and np.allclose(frames.poses[0], pose, atol=SAME)

    def hear(self, message: Payload, now: float) -> None:
        """Take the states of all other robots; raises as `ppaas.nodes.other_robots.others_of` does."""
        self._heard = now, others_of(expect(message, RobotStates), RADIUS)

    def cut_from(self, scan: ScanPoints, laser: Pose2D, frames: KeyFrames, now: float) -> ScanPoints:
        """Return a scan without the points on other robots.

        Parameters
        ----------
        scan : ScanPoints
        laser : Pose2D
            Expected pose of the laser in the map frame.
        frames : KeyFrames
            Key frames of the map.
        now : float
            Monotonic time [s].
        """
        at, robots = self._heard
        age = now - at
        if not robots or age > OTHERS_FRESH or not self.are_in(frames):
            return scan
        moved = (robot.after(age) for robot in robots)
        return without_discs(scan, laser, np.array([(robot.x, robot.y, robot.radius) for robot in moved]))
