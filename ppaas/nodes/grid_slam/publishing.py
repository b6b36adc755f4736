"""Publishers and services of ``grid_slam``: the map as it grows, the robot's pose and its covariance."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.errors import PPaaSError, QuotaExceeded, Unavailable
from ppaas.geometry import Pose2D
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.live.map_canvas import MapCanvas
from ppaas.mapping.scan_tracker import Tracked
from ppaas.maps.cell_rectangle import Rectangle, changed_rectangles
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.occupancy import GridMapMessage, GridUpdate, to_message
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Float64, Header, Time
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav_msgs import GetMap, GetMapResponse, MapMetaData, OccupancyGrid
from ppaas.messages.slam_toolbox import SaveMap, SaveMapRequest, SaveMapResponse, SaveMapResult
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.amcl.messages import pose_message
from ppaas.nodes.base import Context, Reply, Service
from ppaas.nodes.frames import MAP, FrameListener
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.planar_poses import rotated, symmetric
from ppaas.transforms.planar import transform_message

# -- publisher of a map that grows -------------------------------------------------------------------------------------

_NO_CELLS = np.empty((0, 0), np.int8)


class MapPublisher:
    """Publishes ``map``, ``map_metadata`` and ``map_updates``.

    The whole map is published when its size or its corner changes, and otherwise after ``interval``, if it has changed.
    Rectangles of ``map_updates`` refer to the last whole map.

    Parameters
    ----------
    context : Context
        Of the node.
    interval : float
        Time between two whole maps [s].
    """

    def __init__(self, context: Context, interval: float) -> None:
        self._context, self._interval = context, interval
        self._info: GridInfo | None = None
        self._cells: NDArray[np.int8] = _NO_CELLS
        self._canvas: MapCanvas | None = None
        self._changed, self._whole_at = False, 0.0

    def publish(self, canvas: MapCanvas) -> None:
        """Publish what has changed since the last call."""
        touched, fresh = canvas.take_touched(), canvas is not self._canvas
        self._canvas = canvas
        if canvas.extent is None:
            return
        if canvas.info != self._info:
            self._publish_whole(canvas)
            return
        within = Rectangle(0, 0, *canvas.extent.shape) if fresh else touched
        if within is not None:
            self._publish_changes(canvas, within)
        if self._changed and self._context.elapsed() - self._whole_at >= self._interval:
            self._publish_whole(canvas)

    def forget(self) -> None:
        """Forget the map, which was cleared; a later subscriber does not get it."""
        self._info, self._cells, self._canvas, self._changed = None, _NO_CELLS, None, False
        self._context.forget(topics.MAP.name)
        self._context.forget(topics.MAP_METADATA.name)

    def _publish_changes(self, canvas: MapCanvas, within: Rectangle) -> None:
        stamp = Time.of(self._context.now())
        for rectangle in changed_rectangles(self._cells, canvas.cells, within):
            cells = canvas.cells[rectangle.slices].copy()
            self._cells[rectangle.slices] = cells
            self._changed = True
            self._context.publish(topics.MAP_UPDATES.name, GridUpdate(cells, rectangle.row, rectangle.column, stamp))

    def _publish_whole(self, canvas: MapCanvas) -> None:
        stamp, info = Time.of(self._context.now()), canvas.info
        self._info, self._cells = info, canvas.cells.copy()
        self._changed, self._whole_at = False, self._context.elapsed()
        self._context.publish(topics.MAP.name, GridMapMessage(GridMap(canvas.cells.copy(), info), MAP, stamp))
        meta = MapMetaData(info.resolution, info.width, info.height, Pose.of(info.origin), stamp)
        self._context.publish(topics.MAP_METADATA.name, meta)


# -- messages of mapping -----------------------------------------------------------------------------------------------

LEAST_INFORMATION = np.diag((1e-2, 1e-2, 1e-2))
"""Information added to a pose's: 10 m and 10 rad, so that a covariance exists [1/m², 1/m², 1/rad²]."""


FIRST_INFORMATION = np.array((1e8, 0.0, 0.0, 1e8, 0.0, 1e8))
"""Information of the first pose, which defines the map frame: 0.1 mm, 0.1 mrad [1/m², 1/rad²]."""


def robot_covariance(information: NDArray[np.float64], laser: Pose2D, robot: Pose2D) -> NDArray[np.float64]:
    """Return the covariance of the robot's pose in the map frame from the information of its laser's pose.

    Parameters
    ----------
    information : (6,) array
        Information of the pose of the laser in its own frame.
    laser, robot : Pose2D
        Poses in the map frame.

    Returns
    -------
    (3, 3) array
        Covariance of x [m], y [m], theta [rad].
    """
    own = np.asarray(np.linalg.inv(symmetric(information) + LEAST_INFORMATION), np.float64)
    turned = rotated(own, laser.theta)
    lever = np.eye(3)
    lever[:2, 2] = laser.y - robot.y, robot.x - laser.x
    covariance: NDArray[np.float64] = lever @ turned @ lever.T
    return covariance


def tracked_covariance(tracked: Tracked, robot: Pose2D) -> NDArray[np.float64]:
    """Return the covariance (3, 3) of the robot's pose at a tracked scan; the first one has no information."""
    information = tracked.information if tracked.information.any() else FIRST_INFORMATION
    return robot_covariance(information, tracked.pose, robot)


def entropy_of(covariance: NDArray[np.float64]) -> float:
    """Return the entropy of a normal distribution of poses, from its (3, 3) covariance [nat]."""
    return 0.5 * (3.0 * math.log(2.0 * math.pi * math.e) + float(np.linalg.slogdet(covariance)[1]))


def no_map() -> OccupancyGrid:
    """Return the grid of a map that does not exist yet."""
    return OccupancyGrid(Header(frame_id=MAP), MapMetaData(0.0, 0, 0, Pose.of(Pose2D(0.0, 0.0))), [])


# -- map of ``grid_slam`` for others -----------------------------------------------------------------------------------

DYNAMIC_MAP = Service("dynamic_map", GetMap)
SAVE_MAP = Service("save_map", SaveMap)
SERVICES = (DYNAMIC_MAP, SAVE_MAP)

MapSaver = Callable[[str, GridMap, Callable[[PPaaSError | None], None]], None]
"""Saves a map by its name, then calls back with None or the error, now or later."""


class MapServices:
    """Draws the map of a mapper, publishes it, and answers ``dynamic_map`` and ``save_map``.

    Parameters
    ----------
    context : Context
        Of the node.
    interval : float
        Time between two publications of the whole map [s].
    save : callable, optional
        Saves a map for ``save_map``; without it the service is unavailable.

    Attributes
    ----------
    problem : str
        Reason for which the map is not complete; empty if it is.
    """

    def __init__(self, context: Context, interval: float, save: MapSaver | None = None) -> None:
        self.problem = ""
        self._context, self._save = context, save
        self._publisher = MapPublisher(context, interval)

    def publish(self, mapper: LiveMapper) -> None:
        """Publish what has changed in the map. If it would be too large, `problem` says so."""
        try:
            canvas = mapper.draw()
        except QuotaExceeded as error:
            self.problem = f"the map is not complete: {error}"
            return
        self._publisher.publish(canvas)

    def answer(self, request: Message, mapper: LiveMapper | None, reply: Reply) -> None:
        """Reply to a call of ``dynamic_map`` or ``save_map``; without a mapper, that there is no map.

        Raises
        ------
        Unavailable
            Maps cannot be saved here.
        QuotaExceeded
            The map would be too large.
        """
        if isinstance(request, SaveMapRequest):
            self._save_map(request.name.data, mapper, reply)
            return
        grid, stamp = _grid(mapper), Time.of(self._context.now())
        reply(GetMapResponse(no_map() if grid is None else to_message(grid, MAP, stamp)))

    def forget(self) -> None:
        """Forget the map, which was cleared."""
        self.problem = ""
        self._publisher.forget()

    def _save_map(self, name: str, mapper: LiveMapper | None, reply: Reply) -> None:
        if self._save is None:
            raise Unavailable("maps cannot be saved here: get the map by 'dynamic_map'")
        grid = _grid(mapper)
        if grid is None:
            reply(SaveMapResponse(SaveMapResult.RESULT_NO_MAP_RECEIEVD))
            return
        self._save(name, grid, lambda error: reply(error or SaveMapResponse(SaveMapResult.RESULT_SUCCESS)))


def _grid(mapper: LiveMapper | None) -> GridMap | None:
    """Return a copy of the map; None if there is none yet."""
    canvas = None if mapper is None else mapper.draw()
    return None if canvas is None or canvas.extent is None else GridMap(canvas.cells.copy(), canvas.info)


# -- publisher of where a robot is in its map --------------------------------------------------------------------------

JUST_AFTER = 1e-3
"""Time after the newest odometry of a transform that comes without a scan [s]: no two of tf have one stamp."""


class PosePublisher:
    """Publishes ``pose``, ``amcl_pose``, ``grid_slam/shared_pose``, ``entropy``, and ``tf`` map → odom.

    Parameters
    ----------
    context : Context
        Of the node.
    frames : FrameListener
        Frames of the robot.
    parameters : GridSlamParameters
    """

    def __init__(self, context: Context, frames: FrameListener, parameters: GridSlamParameters) -> None:
        self._context, self._frames, self._parameters = context, frames, parameters

    def publish(self, tracked: Tracked, robot: Pose2D, stamp: Time, *, shared: str | None) -> None:
        """Publish the pose of the robot at a tracked scan, and its entropy.

        Parameters
        ----------
        tracked : Tracked
        robot : Pose2D
            In the map frame.
        stamp : Time
            Stamp of the scan.
        shared : str, optional
            Name of the map frame for the other robots, if they know it, so that the pose is for them too.
        """
        covariance = tracked_covariance(tracked, robot)
        pose = pose_message(robot, covariance, stamp)
        for topic in (topics.SLAM_POSE, topics.AMCL_POSE):
            self._context.publish(topic.name, pose)
        if shared is not None:
            header = msgspec.structs.replace(pose.header, frame_id=shared)
            self._context.publish(topics.SHARED_POSE.name, msgspec.structs.replace(pose, header=header))
        self._context.publish(topics.ENTROPY.name, Float64(entropy_of(covariance)))

    def publish_jump(self, map_to_odom: Pose2D) -> None:
        """Publish the transform at once, without a scan: the map is in another frame."""
        newest = self._frames.newest()
        if newest is not None:
            self.publish_transform(map_to_odom, newest + JUST_AFTER)

    def publish_transform(self, map_to_odom: Pose2D, stamp: float) -> None:
        """Publish the pose of the odometry frame in the map frame, stamped ``transform_timeout`` after a time [s].

        Without odometry it is stamped with that time: it is then all of the robot's motion. Nothing is published if
        ``transform_publish_period`` is 0.
        """
        timeout = 0.0 if self._frames.is_without_odometry else self._parameters.transform_timeout
        self._publish(map_to_odom, stamp + timeout)

    def publish_start(self, map_to_odom: Pose2D) -> None:
        """Publish the transform of other odometry from its newest time on, for a robot whose first it is."""
        newest = self._frames.newest()
        if newest is not None:
            self._publish(map_to_odom, newest)

    def _publish(self, map_to_odom: Pose2D, stamp: float) -> None:
        if self._parameters.transform_publish_period > 0.0:
            correction = transform_message(MAP, self._frames.odom, map_to_odom, Time.of(stamp))
            self._context.publish(topics.TF.name, TFMessage([correction]))
