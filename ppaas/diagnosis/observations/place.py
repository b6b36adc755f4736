"""The robot on its map: estimated pose, how sure it is, and what map, scan and robot file say about it."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from ppaas.costmap.causes import barriers_at
from ppaas.costmap.map_layers import MapLayers
from ppaas.diagnosis.observations.facts import PlaceFacts
from ppaas.diagnosis.observations.scans import explained
from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED_THRESHOLD
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.frames import FrameNames
from ppaas.transforms.spatial import LatestFrames


@dataclass(frozen=True, slots=True)
class WatchedRobot:
    """Properties of a robot that its messages do not contain.

    Parameters
    ----------
    id : str
    names : FrameNames
        Names of its frames.
    layers : callable
        Returns the map that it drives on now, None if it makes one.
    makes_map : bool
        Whether it makes a new map.
    camera : bool
        Whether a depth camera makes its scans.
    follows_paths : bool
        Whether it localizes itself and follows paths itself, as an AGV does.
    localizes_itself : bool
        Whether it localizes itself, and is driven by velocities.
    radius : callable
        Returns the largest radius around its centre within its footprint [m], which grows with a load.
    """

    id: str = "ROBOT"
    names: FrameNames = field(default_factory=FrameNames)
    layers: Callable[[], MapLayers | None] = lambda: None
    makes_map: bool = False
    camera: bool = False
    follows_paths: bool = False
    localizes_itself: bool = False
    radius: Callable[[], float] = lambda: 0.0


X_X, Y_Y, YAW_YAW = 0, 7, 35
"""Elements of a covariance of x, y, z, roll, pitch, yaw."""


class PlaceWatch:
    """Watches the localization of a robot.

    Attributes
    ----------
    problem : str
        Reason for which localization uses no scans, from its own report; empty while it uses them.
    """

    def __init__(self) -> None:
        self.problem = ""
        self._pose: Pose2D | None = None
        self._covariance: list[float] = []
        self._at = -math.inf

    def localized(self, message: PoseWithCovarianceStamped, now: float) -> None:
        """Note an estimate that arrived at monotonic time ``now`` [s]."""
        self._pose, self._at = message.pose.pose.planar(), now
        self._covariance = message.pose.covariance

    def facts(self, now: float, scan: LaserScan | None, latest: LatestFrames, robot: WatchedRobot) -> PlaceFacts:
        """Return the facts at monotonic time ``now`` [s], by the last scan and the latest frames of the robot."""
        pose = self._pose
        if pose is None or not pose.is_finite():
            return PlaceFacts(problem=self.problem, radius=robot.radius())
        layers = robot.layers()
        deviation, turn_deviation = self._deviations()
        cell, clearance = _at(pose, layers)
        return PlaceFacts(
            problem=self.problem,
            pose=(pose.x, pose.y, pose.theta),
            silence=now - self._at,
            deviation=deviation,
            turn_deviation=turn_deviation,
            explained=_explained(pose, scan, latest, robot.names.base, layers),
            cell=cell,
            clearance=clearance,
            barrier=_barrier(pose, layers),
            radius=robot.radius(),
        )

    def _deviations(self) -> tuple[float | None, float | None]:
        if len(self._covariance) <= YAW_YAW:
            return None, None
        variances = [self._covariance[index] for index in (X_X, Y_Y, YAW_YAW)]
        if not all(math.isfinite(each) and each >= 0.0 for each in variances):
            return None, None
        return math.sqrt(variances[0] + variances[1]), math.sqrt(variances[2])


def _at(pose: Pose2D, layers: MapLayers | None) -> tuple[str, float | None]:
    """Return the name of the map's cell at a pose, and the distance from there to the nearest wall [m]."""
    if layers is None:
        return "", None
    cell = layers.grid.info.cell_of(pose.x, pose.y)
    if cell is None:
        return "outside", None
    value = int(layers.grid.data[cell])
    name = "unknown" if value < 0 else "occupied" if value >= OCCUPIED_THRESHOLD else "free"
    return name, float(layers.distance[cell])


def _barrier(pose: Pose2D, layers: MapLayers | None) -> str:
    if layers is None:
        return ""
    found = barriers_at(layers, pose.x, pose.y, 0.75 * layers.grid.info.resolution)
    return found[0].text if found else ""


def _explained(
    pose: Pose2D, scan: LaserScan | None, latest: LatestFrames, base: str, layers: MapLayers | None
) -> float | None:
    if scan is None or layers is None:
        return None
    frame = scan.header.frame_id.lstrip("/") or base
    try:
        mount = latest.lookup(base, frame)
    except TransformError:
        return None
    ahead = math.atan2(2.0 * (mount.qw * mount.qz + mount.qx * mount.qy), 1.0 - 2.0 * (mount.qy**2 + mount.qz**2))
    return explained(scan, pose @ Pose2D(mount.x, mount.y, ahead), layers)
