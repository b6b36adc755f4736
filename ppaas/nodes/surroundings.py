"""What a clone knows of the place around its robot: the robot's pose, its laser, the other robots, a local costmap."""

from collections.abc import Iterator
from dataclasses import replace

from ppaas.controllers.base import Velocity
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.local import Disc, LocalCostmap
from ppaas.costmap.memory import ObstacleMemory
from ppaas.costmap.obstacle import LaserReading
from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import PoseArray
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.checks import finite_pose
from ppaas.nodes.frames import BASE_LINK, MAP, ODOM, FrameListener
from ppaas.recoveries.base import AffectedMaps
from ppaas.transforms import tf_time

OTHERS_FRESH = 1.0
"""Seconds for which the positions of other robots are believed."""

SHIFT = 0.1
"""Without anything new to see, the local costmap stays where it is until the robot has moved this far [m]."""

OTHERS_MARGIN = 0.1
"""Added to the radius of another robot [m]: its position is that much in doubt, and it moves."""


class Surroundings:
    """Keeps a local costmap in the frame of the map.

    Parameters
    ----------
    costmap : LocalCostmap
        The window around the robot.
    memory : ObstacleMemory
        Of what has left the window.
    robot_radius : float
        Of this robot; the others are taken to be as large [m].
    tolerance : float
        How old localization and odometry may be [s].
    """

    def __init__(self, costmap: LocalCostmap, memory: ObstacleMemory, robot_radius: float, tolerance: float) -> None:
        self.frames = FrameListener()
        self.velocity = Velocity()
        self._local = costmap
        self._memory = memory
        self.costs: Costmap | None = None
        self._robot_radius = robot_radius
        self._tolerance = tolerance
        self._scan: tuple[LaserScan, LaserReading] | None = None
        self._looked: tuple[Pose2D, tuple[Disc, ...]] | None = None
        self._others: list[Pose2D] = []
        self._others_at = float("-inf")

    def take_scan(self, scan: LaserScan) -> None:
        """Keep a scan for the next update.

        Raises
        ------
        InvalidInput
            Its angles are not finite.
        TransformError
            Its frame is unknown.
        """
        laser = self.frames.tree.lookup(BASE_LINK, _frame_of(scan))
        self._scan = scan, LaserReading.of(scan, laser)

    def take_robots(self, message: PoseArray, now: float) -> None:
        """Take the poses of the other robots, in the frame of the map.

        Raises
        ------
        InvalidInput
            One is not finite.
        TransformError
            They are in another frame.
        """
        if message.header.frame_id.lstrip("/") != MAP:
            raise TransformError(f"the poses of robots are given in {MAP!r}, not in {message.header.frame_id!r}")
        self._others = [finite_pose(pose, "the pose of a robot") for pose in message.poses]
        self._others_at = now

    def pose(self, now: float) -> Pose2D:
        """Return where the robot is in the map.

        Raises
        ------
        TransformError
            Odometry or localization is not there, or too old; the text says which.
        """
        for child, what in ((BASE_LINK, "odometry"), (ODOM, "localization")):
            silence = self.frames.silence(child, now)
            if silence > self._tolerance:
                since = "yet" if silence == float("inf") else f"for {silence:.1f} s"
                raise TransformError(f"no {what} {since}")
        return self.frames.tree.lookup(MAP, BASE_LINK)

    def look_around(self, pose: Pose2D, now: float) -> Costmap:
        """Bring the local costmap up to date and return it; the last one, where there is nothing new to see."""
        others, reading = tuple(self._discs(pose, now)), self._reading()
        if self.costs is None or reading is not None or self._is_elsewhere(pose, others):
            self._looked = pose, others
            self.costs = self._local.update(pose, reading, others)
            self._memory.update(self._local.obstacles, others)
        return self.costs

    def _is_elsewhere(self, pose: Pose2D, others: tuple[Disc, ...]) -> bool:
        """Tell whether this robot or another is not where it was when the local costmap was made."""
        return self._looked is None or self._looked[1] != others or self._looked[0].distance_to(pose) >= SHIFT

    def overlay(self, costmap: Costmap) -> Costmap:
        """Return a costmap of the whole map with what is and was seen; the same one if that is nothing new."""
        return self._memory.overlay(self._local.overlay(costmap))

    def clear(self, around: Pose2D | None = None, beyond: float = 0.0, affected_maps: AffectedMaps = "both") -> None:
        """Forget what was seen, or only what is farther than ``beyond`` [m] from a pose.

        ``affected_maps`` names the window of the local costmap, what is remembered across the map, or both.
        """
        if affected_maps != "local":
            self._memory.clear(around, beyond)
        if affected_maps != "global":
            self._local.clear(around, beyond)
        self._looked = None

    def _reading(self) -> LaserReading | None:
        """Return the scan that came last, once, when the transforms have reached its stamp."""
        if self._scan is None:
            return None
        scan, reading = self._scan
        try:
            origin = self.frames.tree.lookup(MAP, _frame_of(scan), tf_time(scan.header.stamp) or None)
        except TransformError:
            return None  # kept for the next cycle: odometry comes a moment after it
        self._scan = None
        return replace(reading, origin=origin)

    def _discs(self, pose: Pose2D, now: float) -> Iterator[Disc]:
        if now - self._others_at > OTHERS_FRESH:
            return
        reach = self._local.reach + self._robot_radius + OTHERS_MARGIN
        for other in self._others:
            # Two robots cannot stand in one place: that one is this robot's own echo.
            if self._robot_radius < other.distance_to(pose) < reach:
                yield other.x, other.y, self._robot_radius + OTHERS_MARGIN


def _frame_of(scan: LaserScan) -> str:
    return scan.header.frame_id.lstrip("/") or BASE_LINK
