"""Clouds of a robot's sensors: point clouds and depth images, whose points are computed when they are inserted."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.volume.depth_points import points_of_depth
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import CameraInfo, CompressedImage, Image, PointCloud2
from ppaas.nodes.depth_images import CameraInfoWait, DepthCamera, depth_camera_of, depths_of
from ppaas.perception.compressed_depth import decompress
from ppaas.perception.point_cloud import coordinates_of_cloud
from ppaas.transforms.planar import tf_time

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
    camera : DepthCamera or None
        Camera of the depth images, by its last ``camera_info``.
    """

    def __init__(self) -> None:
        self.camera: DepthCamera | None = None
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
