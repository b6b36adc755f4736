"""Points of depth images, as ROS's ``depth_image_proc`` makes them, in the map frame."""

import math
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.mapping.volume.kernels.depth_points import back_project
from ppaas.perception.depth_scan import MILLIMETRES, PinholeCamera
from ppaas.perception.kernels.depth import Depths

_NO_READING = np.iinfo(np.uint16).max
"""Depth of a pixel without a reading in some images in mm; others have 0 there."""


def points_of_depth(
    image: Depths,
    camera: PinholeCamera,
    pose: NDArray[np.float64],
    *,
    fy: float | None = None,
    range_max: float = math.inf,
) -> NDArray[np.float32]:
    """Return the points of the pixels that have a depth, (n, 3) float32: x, y, z in the map frame [m].

    Parameters
    ----------
    image : (height, width) uint16 or float32 array
        Depths along the optical axis, in mm for uint16 and in m for float32. A depth of 0, 65535 mm, or one that is not
        finite means that nothing was seen.
    camera : PinholeCamera
        The camera.
    pose : (4, 4) array
        Transform from the camera to the map frame. The camera has x to the right, y down, and z ahead.
    fy : float, optional
        Focal length along columns [pixels]; by default that along rows.
    range_max : float
        Larger depths are ignored [m].

    Raises
    ------
    InvalidInput
        The image has another size or type than the camera's images, or the pose or focal length is invalid.
    """
    if image.shape != (camera.height, camera.width) or image.dtype not in (np.uint16, np.float32):
        raise InvalidInput(
            f"a depth image must have {camera.width}×{camera.height} pixels of uint16 or float32, by its camera_info, "
            f"not shape {image.shape} of {image.dtype}"
        )
    focal = camera.fx if fy is None else fy
    if pose.shape != (4, 4) or not np.isfinite(pose).all() or not 0.0 < focal < math.inf:
        raise InvalidInput("the pose of a camera must be a finite matrix of 4×4, and its focal length above 0")
    whole = image.dtype == np.uint16
    unit = MILLIMETRES if whole else 1.0
    farthest = (_NO_READING - 0.5) * unit if whole else float(np.finfo(np.float32).max)
    limits = (0.5 * MILLIMETRES if whole else 1e-6, min(range_max, farthest))
    points = np.empty((image.size, 3), np.float32)
    lens = (camera.fx, focal, camera.cx, camera.cy)
    pixels = cast("Depths", np.ascontiguousarray(image).view())
    pixels.flags.writeable = False  # so that the kernel has one signature for each type
    count = back_project(pixels, unit, limits, lens, np.array(pose, np.float64, order="C"), points)
    return points[:count]
