"""Scans of sensors that are no lasers: of the depth images and the point clouds of a bag, as ROS's nodes make them.

``depthimage_to_laserscan`` takes the rows around the optical axis, and ``pointcloud_to_laserscan`` the points near the
height of the sensor.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.messages.geometry_msgs import Transform
from ppaas.nodes.depth_images import DepthLens, depths_of
from ppaas.perception.compressed_depth import decompress
from ppaas.perception.depth_scan import DepthScanner, DepthScanParameters, PinholeCamera
from ppaas.perception.kernels.depth import Depths
from ppaas.perception.point_cloud import coordinates_of_cloud
from ppaas.transforms.spatial import Rigid

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
CAMERA_INFO, CLOUD = "sensor_msgs/msg/CameraInfo", "sensor_msgs/msg/PointCloud2"

ROWS = 10
"""Rows of a depth image that are used; each column has the nearest point of these."""

LEVEL = 0.1
"""Largest height of a point of a cloud above or below its sensor [m]."""

BEAMS = 720
"""Beams of the scan of a cloud, half a degree each."""

NEAREST, FARTHEST = 0.2, 100.0
"""Ranges between which the points of a cloud count [m]: nearer ones are of the robot."""

AHEAD: Final = Rigid(0.0, 0.0, 0.0, -0.5, 0.5, -0.5, 0.5).inverse()
"""Frame with x ahead and z up in the frame of a camera, which has x to the right, y down, and z ahead."""

OF_SCAN = "_scan"
"""End of the name of that frame."""

DEPTHS = ("16UC1", "mono16", "32FC1")
"""Encodings of depth images, with which the formats of compressed ones begin, too."""


@dataclass
class SensorScan:
    """Scan with the fields of ``sensor_msgs/LaserScan``, whose header may get another stamp.

    Parameters
    ----------
    header : header of a message
    angle_min, angle_max, angle_increment, range_min, range_max : float
        As in ``LaserScan`` [rad, m].
    ranges : (b,) float32 array
        Ranges [m]; NaN without a reading.
    """

    header: Any
    angle_min: float
    angle_max: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: NDArray[np.float32]


class DepthImages:
    """Reader of the depth images of a bag, each with the lens by the latest ``camera_info`` beside it."""

    def __init__(self) -> None:
        self._lenses: dict[str, DepthLens] = {}
        self._coloured: set[str] = set()

    def add_info(self, topic: str, info: Any) -> None:
        """Take note of the lens of the images beside a topic; raises ``InvalidInput`` if it is none."""
        k = [float(number) for number in (info.k if hasattr(info, "k") else info.K)]
        self._lenses[_above(topic)] = DepthLens(PinholeCamera(info.width, info.height, k[0], k[2], k[5]), k[4])

    def may_be_depths(self, topic: str) -> bool:
        """Return whether images on a topic are not known to be of colours."""
        return topic not in self._coloured

    def read(self, topic: str, image: Any) -> tuple[DepthLens, Depths] | None:
        """Return an image with its lens; None for one of colours, or if there was no ``camera_info`` yet.

        Raises
        ------
        InvalidInput
            The image is broken.
        """
        is_compressed = not hasattr(image, "encoding")
        kind = str(image.format if is_compressed else image.encoding)
        if not kind.startswith(DEPTHS):
            self._coloured.add(topic)
            return None
        lens = self._lens_of(topic)
        if lens is None:
            return None
        return lens, decompress(kind, bytes(image.data)) if is_compressed else depths_of(image)

    def _lens_of(self, topic: str) -> DepthLens | None:
        above = _above(topic)
        while above not in self._lenses and above:
            above = _above(above)
        return self._lenses.get(above)


def _above(topic: str) -> str:
    return topic.rpartition("/")[0]


class SensorScans:
    """Converter of depth images and clouds to scans."""

    def __init__(self) -> None:
        self._images = DepthImages()
        self._scanners: dict[tuple[str, DepthLens], DepthScanner] = {}
        self._optical: set[str] = set()
        self.broken = 0

    def may_use(self, topic: str, kind: str) -> bool:
        """Return whether a message has to be read."""
        return kind in (CAMERA_INFO, CLOUD) or (kind in (IMAGE, COMPRESSED) and self._images.may_be_depths(topic))

    def scan(self, topic: str, kind: str, message: Any) -> SensorScan | None:
        """Return the scan of a message; None if there is none in it. Broken ones are counted."""
        try:
            if kind == CAMERA_INFO:
                self._images.add_info(topic, message)
                return None
            if kind == CLOUD:
                return scan_of_cloud(message)
            read = self._images.read(topic, message)
            return None if read is None else self._of_depths(topic, message.header, *read)
        except (InvalidInput, InvalidParameter):
            self.broken += 1
            return None

    def frames(self) -> Iterator[tuple[str, str, Transform]]:
        """Yield the frames of the scans of depth images: parent, name, transform to it."""
        for frame in sorted(self._optical):
            yield frame, frame + OF_SCAN, AHEAD.to_message()

    def _of_depths(self, topic: str, header: Any, lens: DepthLens, depths: Depths) -> SensorScan:
        key = (topic, lens)
        if key not in self._scanners:
            rows = max(1, min(ROWS, int(2.0 * min(lens.lens.cy, lens.lens.height - 1 - lens.lens.cy))))
            self._scanners[key] = DepthScanner(lens.lens, DepthScanParameters(scan_height=rows))
        scanner, limits = self._scanners[key], DepthScanParameters()
        self._optical.add(header.frame_id.lstrip("/"))
        header.frame_id += OF_SCAN
        return SensorScan(
            header, scanner.angle_min, scanner.angle_max, scanner.angle_increment, limits.range_min, limits.range_max,
            scanner.scan(depths),
        )  # fmt: skip


def scan_of_cloud(cloud: Any) -> SensorScan:
    """Return the scan of the points of a cloud near the height of its sensor, which is taken to be level.

    Raises
    ------
    InvalidInput
        The cloud is broken.
    """
    x, y, z = (axis.ravel().astype(np.float64) for axis in coordinates_of_cloud(cloud))
    ranges = np.hypot(x, y)
    near = (np.abs(z) <= LEVEL) & (ranges >= NEAREST) & (ranges < FARTHEST)
    step = math.tau / BEAMS
    beams = np.minimum(((np.arctan2(y[near], x[near]) + math.pi) / step).astype(np.int64), BEAMS - 1)
    nearest = np.full(BEAMS, np.inf)
    np.minimum.at(nearest, beams, ranges[near])
    found = np.where(np.isfinite(nearest), nearest, np.nan).astype(np.float32)
    first = -math.pi + 0.5 * step
    return SensorScan(cloud.header, first, first + (BEAMS - 1) * step, step, NEAREST, FARTHEST, found)
