"""Messages of ``octomap_server``: clouds in, whose points are computed when inserted; octrees out."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.mapping.volume.depth_points import points_of_depth
from ppaas.maps.octomap import octomap_nodes
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.octomap_msgs import Octomap
from ppaas.messages.sensor_msgs import CameraInfo, CompressedImage, Image, PointCloud2
from ppaas.nodes.depth_images import CameraInfoWait, DepthLens, depth_camera_of, depths_of
from ppaas.nodes.frames import MAP
from ppaas.perception.compressed_depth import decompress
from ppaas.perception.point_cloud import coordinates_of_cloud
from ppaas.planar_poses import PoseArray
from ppaas.transforms.planar import tf_time

# -- clouds of a robot's sensors ---------------------------------------------------------------------------------------

Points = NDArray[np.float32]
Placed = Callable[[NDArray[np.float64]], Points]
"""Returns the points of a cloud (n, 3) in the frame to which a transform (4, 4) leads from the sensor's frame [m]."""


class SensorCloud(NamedTuple):
    """Cloud of a sensor.

    Parameters
    ----------
    frame : str
        Frame of the sensor.
    stamp : float
        Time of the cloud, 0 for the newest odometry's [s].
    at : float
        Time of arrival, by the executor's clock [s].
    placed : callable
        Returns the points.
    """

    frame: str
    stamp: float
    at: float
    placed: Placed


class CloudReader:
    """Reads point clouds and depth images.

    Attributes
    ----------
    camera : DepthLens or None
        Camera of the depth images, by its last ``camera_info``.
    """

    def __init__(self) -> None:
        self.camera: DepthLens | None = None
        self._wait = CameraInfoWait()

    def of_points(self, message: PointCloud2, now: float) -> SensorCloud:
        """Return the cloud of a message.

        Raises
        ------
        InvalidInput
            It has no coordinates, or fewer bytes than its size requires.
        """
        axes = coordinates_of_cloud(message)
        return _cloud(message.header, now, lambda pose: _moved(axes, pose))

    def of_image(self, message: Image | CompressedImage, now: float) -> SensorCloud | None:
        """Return the cloud of a depth image; None before the first ``camera_info``.

        Raises
        ------
        InvalidInput
            The image is malformed, or there was no ``camera_info`` for a second.
        """
        camera = self.camera
        if camera is None:
            self._wait.check(now)
            return None

        def placed(pose: NDArray[np.float64]) -> Points:
            image = depths if isinstance(message, Image) else decompress(message.format, message.data)
            return points_of_depth(image, camera.lens, pose, fy=camera.fy)

        depths = depths_of(message) if isinstance(message, Image) else np.empty((0, 0), np.uint16)
        return _cloud(message.header, now, placed)

    def set_camera(self, info: CameraInfo) -> None:
        """Use a ``camera_info``.

        Raises
        ------
        InvalidInput
            It is not a camera's image.
        """
        self.camera = depth_camera_of(info)


def _cloud(header: Header, now: float, placed: Placed) -> SensorCloud:
    return SensorCloud(header.frame_id.lstrip("/"), tf_time(header.stamp), now, placed)


def _moved(axes: list[NDArray[np.floating]], pose: NDArray[np.float64]) -> Points:
    """Return the points (n, 3) of coordinates (height, width) of each axis, after a transform (4, 4)."""
    points = np.stack([axis.ravel() for axis in axes], axis=1).astype(np.float64)
    with np.errstate(invalid="ignore", over="ignore"):  # of points that are not finite, and left out later
        moved: Points = (points @ pose[:3, :3].T + pose[:3, 3]).astype(np.float32)
    return moved


# -- messages of ``octomap_server`` ------------------------------------------------------------------------------------

# Text of a byte as int8, padded to five characters, so that one look-up yields the text of a whole octree.
_TEXT = np.array([f"{value},".ljust(5).encode() for value in (*range(128), *range(-128, 0))], "S5")


@dataclass(frozen=True, slots=True)
class OctomapFile:
    """OctoMap file, converted to a message only when it leaves the process.

    Parameters
    ----------
    data : bytes
        The file.
    binary : bool
        Whether it is a binary file (``.bt``).
    resolution : float
        Edge of the finest voxels [m].
    stamp : Time
    """

    data: bytes
    binary: bool
    resolution: float
    stamp: Time

    def to_message(self) -> Octomap:
        """Return ``octomap_msgs/Octomap``."""
        nodes = np.frombuffer(octomap_nodes(self.data), np.uint8)
        text = np.take(_TEXT, nodes).tobytes().translate(None, b" ")
        data = msgspec.Raw(b"[%b]" % text[:-1])
        return Octomap(Header(stamp=self.stamp, frame_id=MAP), self.binary, "OcTree", self.resolution, data)


def poses_of(numbers: list[float], name: str) -> PoseArray:
    """Return the poses (k, 3) in a field of a request; raises ``InvalidInput`` if they are none."""
    poses = np.array(numbers, np.float64)
    if len(poses) % 3 or not np.isfinite(poses).all():
        raise InvalidInput(f"{name} must be poses: three finite numbers for each key frame")
    return poses.reshape(-1, 3)
