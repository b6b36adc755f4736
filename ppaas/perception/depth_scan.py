"""A depth image as a laser scan, so that a robot with a depth camera drives as one with a laser.

After ROS's ``depthimage_to_laserscan``: of some rows about the optical axis, each column gives the nearest thing in
it, at the angle at which the camera sees that column. So a table whose edge is in these rows is seen, which a laser
below it passes by.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.parameters import Parameters
from ppaas.perception.kernels.depth import Depths, nearest, spread

MILLIMETRES = 0.001
MOST_PIXELS = 1 << 26
"""Of an image."""


@dataclass(frozen=True, slots=True)
class PinholeCamera:
    """A camera without distortion, as depth cameras give their images [pixels].

    Parameters
    ----------
    width, height : int
        Of its images.
    fx : float
        Focal length along rows.
    cx, cy : float
        Where the optical axis meets the image.

    Raises
    ------
    InvalidInput
        There is no such camera.
    """

    width: int
    height: int
    fx: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        """Check that it can see."""
        if not (self.width > 1 and self.height > 0 and self.width * self.height <= MOST_PIXELS):
            raise InvalidInput(f"a depth image is of 2×1 to {MOST_PIXELS} pixels, not {self.width}×{self.height}")
        centred = 0.0 <= self.cx <= self.width - 1 and 0.0 <= self.cy <= self.height - 1
        if not (math.isfinite(self.fx) and self.fx > 0.0 and centred):
            raise InvalidInput(
                f"camera_info.K must have a focal length above 0 and an optical axis within the image of "
                f"{self.width}×{self.height}, not fx {self.fx:g}, cx {self.cx:g}, cy {self.cy:g}"
            )


class DepthScanParameters(Parameters, frozen=True):
    """Parameters of ROS's node, with its names and defaults.

    Parameters
    ----------
    scan_height : int
        Rows that are looked at, about the optical axis.
    scan_time : float
        Between two images [s].
    range_min, range_max : float
        What is nearer or farther counts as nothing [m].
    output_frame_id : str
        Of the scan: x ahead, y to the left. The image's own frame looks along z.
    """

    scan_height: int = 1
    scan_time: float = 0.033
    range_min: float = 0.45
    range_max: float = 10.0
    output_frame_id: str = "camera_depth_frame"

    def __post_init__(self) -> None:
        """Check the ranges."""
        if not 1 <= self.scan_height <= MOST_PIXELS:
            raise InvalidParameter(f"scan_height must be a number of rows from 1 on, not {self.scan_height}")
        if not 0.0 <= self.range_min < self.range_max < math.inf:
            raise InvalidParameter(
                f"range_min and range_max must be finite, not negative, and the first the smaller one, "
                f"not {self.range_min} and {self.range_max}"
            )
        if not 0.0 <= self.scan_time < math.inf:
            raise InvalidParameter(f"scan_time must be finite and not negative, not {self.scan_time}")
        if not self.output_frame_id:
            raise InvalidParameter("output_frame_id must name the frame of the scan, such as 'camera_depth_frame'")


class DepthScanner:
    """Turns the images of one camera into scans.

    Parameters
    ----------
    camera : PinholeCamera
    parameters : DepthScanParameters

    Attributes
    ----------
    angle_min, angle_max, angle_increment : float
        Of the scan [rad], counter-clockwise: the first beam is that of the last column.

    Raises
    ------
    InvalidParameter
        The image has fewer rows about its optical axis than are to be looked at.
    """

    def __init__(self, camera: PinholeCamera, parameters: DepthScanParameters) -> None:
        self.camera = camera
        self._parameters = parameters
        first = int(camera.cy - parameters.scan_height / 2.0)
        if not 0 <= first <= camera.height - parameters.scan_height:
            raise InvalidParameter(
                f"scan_height {parameters.scan_height} about row {camera.cy:g} reaches beyond the {camera.height} rows "
                "of the image: make it smaller"
            )
        self._rows = slice(first, first + parameters.scan_height)
        across = (np.arange(camera.width) - camera.cx) / camera.fx
        angles = -np.arctan(across)
        self.angle_min, self.angle_max = float(angles[-1]), float(angles[0])
        self.angle_increment = (self.angle_max - self.angle_min) / (camera.width - 1)
        self._beams = ((angles - self.angle_min) / self.angle_increment + 1e-9).astype(np.int32)
        self._slant = np.hypot(1.0, across)
        self._limits: dict[np.dtype[np.generic], tuple[Depths, Depths]] = {}

    def scan(self, image: Depths) -> NDArray[np.float32]:
        """Return the range of each beam [m]; NaN where nothing was seen.

        Parameters
        ----------
        image : (height, width) uint16 or float32 array
            Depth along the optical axis, in mm if they are whole numbers, else in m; 0 or NaN where it is not known.

        Raises
        ------
        InvalidInput
            It is of another size than the camera's images, or of another type.
        """
        camera = self.camera
        if image.shape != (camera.height, camera.width) or image.dtype not in (np.uint16, np.float32):
            raise InvalidInput(
                f"expected a depth image of {camera.width}×{camera.height} uint16 or float32, as its camera_info says, "
                f"got {image.shape[1]}×{image.shape[0]} {image.dtype}"
            )
        low, high = self._limits_of(image.dtype)
        farthest = np.iinfo(np.uint16).max if image.dtype == np.uint16 else np.inf
        least = np.full(camera.width, farthest, image.dtype)
        nearest(image[self._rows], low, high, least)
        unit = MILLIMETRES if image.dtype == np.uint16 else 1.0
        ranges = np.where(least < farthest, least * (self._slant * unit), np.inf).astype(np.float32)
        scan = np.full(camera.width, np.inf, np.float32)
        spread(ranges, self._beams, scan)
        scan[np.isinf(scan)] = np.nan
        return scan

    def _limits_of(self, kind: np.dtype[np.generic]) -> tuple[Depths, Depths]:
        """Return the least and the greatest depth of each column whose range counts; a depth of 0 never does."""
        if kind not in self._limits:
            own = self._parameters
            if kind == np.uint16:
                low, high = (limit / self._slant / MILLIMETRES for limit in (own.range_min, own.range_max))
                low, high = np.maximum(np.ceil(low - 1e-6), 1.0), np.floor(high + 1e-6)
                self._limits[kind] = _shorts(low), _shorts(high)
            else:
                low, high = own.range_min / self._slant, own.range_max / self._slant
                self._limits[kind] = np.maximum(low, 1e-6).astype(np.float32), high.astype(np.float32)
        return self._limits[kind]


def _shorts(limits: NDArray[np.float64]) -> NDArray[np.uint16]:
    # The greatest number says that nothing was found.
    return np.minimum(limits, np.iinfo(np.uint16).max - 1).astype(np.uint16)
