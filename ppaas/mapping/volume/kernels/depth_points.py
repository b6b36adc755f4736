"""Kernel: points of a depth image in the map frame."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled


@compiled
def back_project(
    image: NDArray[np.uint16] | NDArray[np.float32],
    unit: float,
    depths: tuple[float, float],
    lens: tuple[float, float, float, float],
    pose: NDArray[np.float64],
    points: NDArray[np.float32],
) -> int:
    """Find the points of the pixels with a valid depth, row by row; return their number.

    Parameters
    ----------
    image : (height, width) uint16 or float32 array
        Depths along the optical axis.
    unit : float
        Unit of the depths [m].
    depths : tuple of two float
        Least and greatest valid depth [m], both included. NaN is never valid.
    lens : tuple of four float
        Focal lengths fx, fy and principal point cx, cy [pixels].
    pose : (4, 4) float64 array
        Transform from the camera (x to the right, y down, z ahead) to the map frame.
    points : (n, 3) float32 array
        Out: x, y, z [m]; n is at least the number of pixels.
    """
    fx, fy, cx, cy = lens
    count = 0
    for v in range(image.shape[0]):
        for u in range(image.shape[1]):
            z = image[v, u] * unit
            if not depths[0] <= z <= depths[1]:
                continue
            x, y = (u - cx) / fx * z, (v - cy) / fy * z
            for axis in range(3):
                place = pose[axis, 0] * x + pose[axis, 1] * y + pose[axis, 2] * z + pose[axis, 3]
                points[count, axis] = place
            count += 1
    return count


def warm() -> None:
    """Call the kernel once for each type of image, so that it is compiled or loaded from the cache."""
    pose, points, one = np.eye(4), np.zeros((1, 3), np.float32), (1.0, 1.0, 1.0, 1.0)
    for image in (np.zeros((1, 1), np.uint16), np.zeros((1, 1), np.float32)):
        image.flags.writeable = False
        back_project(image, 1.0, (0.0, 1.0), one, pose, points)
