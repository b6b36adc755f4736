"""Conversion of depth images to laser scans, so that a robot with a depth camera drives like one with a laser.

It follows ROS's ``depthimage_to_laserscan``: from the rows around the optical axis, each column gives the least depth,
at the angle at which the camera sees that column. So the edge of a table in these rows is seen, while a laser scans
below it.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.parameters import Parameters
from ppaas.perception.kernels.depth import Depths, nearest, spread

MILLIMETRES = 0.001
"""One millimetre [m]."""

MOST_PIXELS = 1 << 26
"""Limit of the number of pixels of an image."""


@dataclass(frozen=True, slots=True)
class PinholeCamera:
    """Camera without distortion. Depth cameras rectify their images, so this model applies to them.

    Parameters
    ----------
    width, height : int
        Size of the images [pixels].
    fx : float
        Focal length along rows [pixels].
    cx, cy : float
        Principal point, where the optical axis meets the image [pixels].

    Raises
    ------
    InvalidInput
        A parameter is out of range or not finite.
    """

    width: int
    height: int
    fx: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        """Check the size and the intrinsic parameters."""
        if not (self.width > 1 and self.height > 0 and self.width * self.height <= MOST_PIXELS):
            raise InvalidInput(
                f"a depth image must have from 2×1 to {MOST_PIXELS} pixels, not {self.width}×{self.height}"
            )
        centred = 0.0 <= self.cx <= self.width - 1 and 0.0 <= self.cy <= self.height - 1
        if not (math.isfinite(self.fx) and self.fx > 0.0 and centred):
            raise InvalidInput(
                f"camera_info.K must have a focal length above 0 and an optical axis within the image of "
                f"{self.width}×{self.height}, not fx {self.fx:g}, cx {self.cx:g}, cy {self.cy:g}"
            )


class DepthScanParameters(Parameters, frozen=True):
    """Parameters of ROS's node ``depthimage_to_laserscan``, with its names and defaults.

    Parameters
    ----------
    scan_height : int
        Number of rows around the optical axis that are used.
    scan_time : float
        Time between two images [s].
    range_min, range_max : float
        Depths outside these ranges are ignored [m].
    output_frame_id : str
        Frame of the scan, with x ahead and y to the left. (The image's own frame has z ahead.)
    """

    scan_height: int = 1
    scan_time: float = 0.033
    range_min: float = 0.45
    range_max: float = 10.0
    output_frame_id: str = "camera_depth_frame"

    def __post_init__(self) -> None:
        """Check the ranges."""
        if not 1 <= self.scan_height <= MOST_PIXELS:
            raise InvalidParameter(f"scan_height must be at least 1 row, not {self.scan_height}")
        if not 0.0 <= self.range_min < self.range_max < math.inf:
            raise InvalidParameter(
                f"range_min and range_max must be finite and not negative, and range_min the smaller one, not "
                f"{self.range_min} and {self.range_max}"
            )
        if not 0.0 <= self.scan_time < math.inf:
            raise InvalidParameter(f"scan_time must be finite and not negative, not {self.scan_time}")
        if not self.output_frame_id:
            raise InvalidParameter("output_frame_id must be the frame of the scan, such as 'camera_depth_frame'")


class DepthScanner:
    """Converter of one camera's depth images to scans.

    Parameters
    ----------
    camera : PinholeCamera
        The camera.
    parameters : DepthScanParameters
        Parameters of the conversion.

    Attributes
    ----------
    angle_min, angle_max, angle_increment : float
        Angles of the scan, counter-clockwise [rad]; the first beam belongs to the last column.

    Raises
    ------
    InvalidParameter
        The image has fewer than ``scan_height`` rows around the optical axis.
    """

    def __init__(self, camera: PinholeCamera, parameters: DepthScanParameters) -> None:
        self.camera = camera
        self._parameters = parameters
        first = int(camera.cy - parameters.scan_height / 2.0)
        if not 0 <= first <= camera.height - parameters.scan_height:
            raise InvalidParameter(
                f"scan_height {parameters.scan_height} around row {camera.cy:g} exceeds the image of {camera.height} "
                "rows: reduce it"
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
        """Return the range of each beam [m], NaN if nothing was seen, as (width,) float32 array.

        Parameters
        ----------
        image : (height, width) uint16 or float32 array
            Depths along the optical axis, in mm for uint16 and in m for float32; 0 or NaN where unknown.

        Raises
        ------
        InvalidInput
            The image has another size than the camera's images, or another type.
        """
        camera = self.camera
        if image.shape != (camera.height, camera.width) or image.dtype not in (np.uint16, np.float32):
            raise InvalidInput(
                f"a depth image must have {camera.width}×{camera.height} pixels of uint16 or float32, by its "
                f"camera_info, not {image.shape[1]}×{image.shape[0]} of {image.dtype}"
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
        """Return the least and the greatest valid depth of each column, in units of the image; above 0."""
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
    # The greatest uint16 marks columns without a valid depth.
    return np.minimum(limits, np.iinfo(np.uint16).max - 1).astype(np.uint16)
