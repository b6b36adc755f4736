"""Work on the 3D map of ``octomap_server``, which runs in jobs, one after the other."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.change_log import LogChange, LogEntry
from ppaas.errors import PPaaSError
from ppaas.mapping.volume.exports import binary_file, full_file, project_volume
from ppaas.mapping.volume.ground_plane import ground_mask
from ppaas.mapping.volume.key_frame_poses import Anchor, KeyFramePoses
from ppaas.mapping.volume.registration import CloudRegistration, apply
from ppaas.mapping.volume.submap_volume import SubmapVolume
from ppaas.mapping.volume.volume_log import VolumeLogWriter, read_log
from ppaas.maps.grid import GridMap
from ppaas.nodes import topics
from ppaas.nodes.octomap_server.clouds import Placed, Points
from ppaas.nodes.octomap_server.parameters import OctomapServerParameters
from ppaas.planar_poses import PoseArray
from ppaas.thread_budget import Threads
from ppaas.transforms.spatial import Rigid, matrix_of


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
class Rendered:
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

    def render(self, names: Collection[str]) -> Rendered:
        """Return the maps for some topics.

        Raises
        ------
        InvalidMap
            The projected map would be too large.
        """
        volume = self._map.volume
        return Rendered(
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
