"""Work on the 3D map of ``octomap_server``, in jobs one after the other: poses of clouds, insertion, the log."""

import logging
from collections import deque
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.change_log import LogChange, LogEntry
from ppaas.errors import PPaaSError, TransformError
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.exports import binary_file, full_file, project_volume
from ppaas.mapping.volume.ground_plane import ground_mask
from ppaas.mapping.volume.key_frame_poses import NO_KEY_FRAMES, Anchor, KeyFramePoses
from ppaas.mapping.volume.registration import CloudRegistration, apply
from ppaas.mapping.volume.submap_volume import SubmapVolume
from ppaas.mapping.volume.volume_log import VolumeLogWriter, read_log
from ppaas.maps.grid import GridMap
from ppaas.nodes import topics
from ppaas.nodes.frames import BASE_FOOTPRINT, MAP, FrameListener
from ppaas.nodes.octomap_server.job_queue import JobQueue
from ppaas.nodes.octomap_server.messages import Placed, Points, SensorCloud
from ppaas.nodes.octomap_server.parameters import OctomapServerParameters
from ppaas.planar_poses import PoseArray
from ppaas.thread_budget import Threads
from ppaas.transforms.spatial import Rigid, matrix_of

# -- work on the 3D map of ``octomap_server``, which runs in jobs, one after the other ---------------------------------


@dataclass(frozen=True, slots=True)
class PlacedCloud:
    """Cloud with its pose.

    Parameters
    ----------
    placed : callable
        Returns the points.
    mount : Rigid
        Pose of the sensor in the frame of the robot, whose origin is on the floor.
    robot : Rigid
        Pose of that frame in the map frame.
    anchor : Anchor, optional
        Key frame that the cloud hangs on.
    """

    placed: Placed
    mount: Rigid
    robot: Rigid
    anchor: Anchor | None


@dataclass(frozen=True, slots=True)
class RenderedMaps:
    """Maps of one state, for those topics that they were asked for.

    Parameters
    ----------
    binary, full : bytes, optional
        OctoMap files.
    grid : GridMap, optional
        Projected map; None also if the map is empty.
    """

    binary: bytes | None = None
    full: bytes | None = None
    grid: GridMap | None = None


class MapWork:
    """3D map of a robot. One thread at once may call its methods.

    Parameters
    ----------
    parameters : OctomapServerParameters
    threads : callable
        Returns the largest number of threads that kernels may use now.

    Raises
    ------
    Unavailable
        Clouds are to be registered, and the library for it is not installed.
    """

    def __init__(self, parameters: OctomapServerParameters, threads: Threads) -> None:
        self._parameters, self._ground = parameters, parameters.ground_filter()
        self._map = SubmapVolume(parameters.volume(), threads)
        self._registration = CloudRegistration(threads) if parameters.registration else None
        self._log = VolumeLogWriter()

    def log_change(self, key_frames: KeyFramePoses) -> LogChange | None:
        """Return the change of the log of the map, which is at the poses of these key frames; see `VolumeLogWriter`."""
        return self._log.write(self._map, key_frames)

    def restore(self, entries: Sequence[LogEntry]) -> KeyFramePoses:
        """Continue the map of a log; return the key frames of its submaps, at whose poses it is.

        Raises
        ------
        InvalidMap
            The log is damaged. The map is empty, and the log begins again.
        QuotaExceeded
            There are more blocks than allowed.
        """
        try:
            key_frames = read_log(entries, self._map)
        except PPaaSError:
            self._map.clear()
            self._log.take_over(entries, None)
            raise
        self._log.take_over(entries, self._map)
        return key_frames

    def insert(self, cloud: PlacedCloud) -> str:
        """Add a cloud, and return what limits the map; empty if nothing does.

        Raises
        ------
        InvalidInput
            The cloud is broken, or too far from the origin of the map.
        QuotaExceeded
            The map would be too large; it is unchanged.
        """
        points, ground = self._points(cloud)
        sensor = np.array((cloud.robot @ cloud.mount)[:3])
        if self._registration is not None:
            correction = self._registration.correction(points)
            points, sensor = apply(correction, points), correction[:3, :3] @ sensor + correction[:3, 3]
        self._map.insert(points, sensor, cloud.anchor, ground)
        return self._limit()

    def correct(self, before: KeyFramePoses, after: KeyFramePoses) -> bool:
        """Move the map with its key frames; return whether it has changed."""
        changed = self._map.correct(before, after)
        if changed and self._registration is not None:
            self._registration.forget()
        return changed

    def clear_box(self, low: ArrayLike, high: ArrayLike) -> None:
        """Make the voxels in a box free, see `SubmapVolume.clear_box`."""
        self._map.clear_box(low, high)

    def clear(self) -> None:
        """Forget the map."""
        self._map.clear()
        if self._registration is not None:
            self._registration.forget()

    def render(self, names: Collection[str]) -> RenderedMaps:
        """Return the maps for some topics.

        Raises
        ------
        InvalidMap
            The projected map would be too large.
        """
        volume = self._map.volume
        return RenderedMaps(
            binary_file(volume) if topics.OCTOMAP_BINARY.name in names else None,
            full_file(volume) if topics.OCTOMAP_FULL.name in names else None,
            project_volume(volume) if topics.PROJECTED_MAP.name in names and len(volume.blocks) else None,
        )

    def file(self, key_frames: KeyFramePoses, before: PoseArray, after: PoseArray) -> bytes:
        """Return the binary OctoMap file of the map with moved key frames, see `SubmapVolume.moved`; empty if it is."""
        volume = self._map.moved(key_frames, before, after)
        return binary_file(volume) if len(volume.blocks) else b""

    def _points(self, cloud: PlacedCloud) -> tuple[Points, NDArray[np.bool_] | None]:
        """Return the points of a cloud in the map frame within the limits, and which of them are of the ground."""
        if not self._parameters.filter_ground_plane:
            points = cloud.placed(matrix_of(cloud.robot @ cloud.mount))
            return points[self._within(points)], None
        points = cloud.placed(matrix_of(cloud.mount))
        points = points[self._within(points)]
        ground = ground_mask(points, self._ground)
        return apply(matrix_of(cloud.robot), points), ground

    def _within(self, points: Points) -> NDArray[np.bool_]:
        """Return whether points (n, 3) are within the limits of the parameters, (n,)."""
        own = self._parameters
        low = (own.point_cloud_min_x, own.point_cloud_min_y, own.point_cloud_min_z)
        high = (own.point_cloud_max_x, own.point_cloud_max_y, own.point_cloud_max_z)
        return np.asarray(((points >= low) & (points <= high)).all(axis=1))

    def _limit(self) -> str:
        most = self._parameters.max_blocks
        if self._map.fixed:
            return f"the map has more than half of max_blocks ({most}): it no longer moves when loops are closed"
        if self._map.joined:
            return f"the map has max_blocks ({most}): {self._map.joined} of its parts move together with others"
        return ""


# -- poses of clouds in the map frame ----------------------------------------------------------------------------------

KEPT = 100
"""Number of key frames of which the odometry is stored: more than clouds wait for."""

MOST_APART = 5.0
"""Distance from its key frame above which a cloud is placed by ``tf``: the odometry was reset [m]."""


class CloudPoses:
    """Finds the poses of clouds.

    While a node makes a map and publishes its key frames, a cloud is placed by the odometry since the last key frame.
    So it needs no transform of the map frame, which jumps when a loop is closed.

    Parameters
    ----------
    frames : FrameListener
        Frames of the robot.

    Attributes
    ----------
    key_frames : KeyFramePoses
        Newest poses of the key frames.
    """

    def __init__(self, frames: FrameListener) -> None:
        self.key_frames: KeyFramePoses = NO_KEY_FRAMES
        self._frames = frames
        self._odometry: deque[tuple[float, Pose2D]] = deque(maxlen=KEPT)

    def set_key_frames(self, key_frames: KeyFramePoses) -> None:
        """Use new poses of the key frames, and note the odometry at the newest of them."""
        self.key_frames = key_frames
        if not len(key_frames):
            self._odometry.clear()
            return
        newest = float(key_frames.stamps[-1])
        if self._odometry and self._odometry[-1][0] == newest:
            return
        try:
            self._odometry.append((newest, self._frames.odometry(newest)))
        except TransformError:
            return  # it is a key frame of an earlier drive

    def newest(self) -> float | None:
        """Return the time up to which clouds can be placed [s]; None if none can be."""
        if len(self.key_frames):
            return self._frames.newest()
        return self._frames.tree.common_time(MAP, self._frames.base)

    def place(self, cloud: SensorCloud, stamp: float) -> PlacedCloud:
        """Return a cloud with its pose at a time [s].

        Raises
        ------
        TransformError
            The frame of the sensor is unknown, or the pose of the robot at that time.
        """
        floor = Rigid(z=-self._frames.height_of(BASE_FOOTPRINT))
        anchor, robot = self._robot(stamp)
        return PlacedCloud(cloud.placed, floor @ self._frames.mount(cloud.frame), Rigid.planar(robot), anchor)

    def _robot(self, stamp: float) -> tuple[Anchor | None, Pose2D]:
        """Return the key frame for a cloud and the pose of the robot in the map frame."""
        anchor = self.key_frames.anchor(stamp) if len(self.key_frames) else None
        if anchor is not None:
            before = next((pose for at, pose in reversed(self._odometry) if at == anchor.stamp), None)
            moved = before.inverse() @ self._frames.odometry(stamp) if before is not None else None
            if moved is not None and moved.distance_to(Pose2D(0.0, 0.0)) <= MOST_APART:
                return anchor, anchor.pose @ moved
        return anchor, self._frames.in_map(stamp)


logger = logging.getLogger(__name__)


# -- log of the 3D map of ``octomap_server`` ---------------------------------------------------------------------------


class MapLog:
    """Log of a map.

    Parameters
    ----------
    jobs : JobQueue
        Jobs of the node.
    work : MapWork
        The map.

    Attributes
    ----------
    loss : str
        Reason for which the map of the log is lost; empty if it is not.
    """

    def __init__(self, jobs: JobQueue, work: MapWork) -> None:
        self.loss = ""
        self._jobs, self._work = jobs, work
        self._change: LogChange | None = None
        self._logged, self._running = 0, False

    def write(self, revision: int, key_frames: KeyFramePoses) -> None:
        """Collect what has changed in a job, if the map has another revision than at the last call.

        Parameters
        ----------
        revision : int
            Of the map.
        key_frames : KeyFramePoses
            Key frames at whose poses it is.
        """
        if revision != self._logged and not self._running:
            self._running = True
            self._jobs.add(partial(self._work.log_change, key_frames), partial(self._on_written, revision))

    def take(self) -> LogChange | None:
        """Return what was collected since the last call; None if nothing was."""
        change, self._change = self._change, None
        return change

    def restore(self, entries: Sequence[LogEntry], done: Callable[[KeyFramePoses | None], None]) -> None:
        """Read the map of a log in a job.

        Parameters
        ----------
        entries : sequence of LogEntry
            All entries, sorted by number.
        done : callable
            Called with the key frames of the map, at whose poses it is; None if it is lost.
        """
        self._jobs.add(partial(self._work.restore, entries), partial(self._on_restored, done))

    def _on_written(self, revision: int, change: LogChange | PPaaSError | None) -> None:
        self._running = False
        if isinstance(change, PPaaSError):
            logger.warning("the log of the 3D map was not written: %s", change)
            return
        self._logged = revision
        if change is not None:
            self._change = change if self._change is None else self._change.then(change)

    def _on_restored(self, done: Callable[[KeyFramePoses | None], None], result: KeyFramePoses | PPaaSError) -> None:
        if isinstance(result, PPaaSError):
            logger.warning("the 3D map that the robot was making is lost: %s", result)
            self.loss = f"the 3D map so far is lost: {result}"
        done(None if isinstance(result, PPaaSError) else result)
