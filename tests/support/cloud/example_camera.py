"""Module ``hardware`` of the example with a depth camera: a robot that stands in an empty hall.

The test copies it next to the example.
"""

import time

import numpy as np
from numpy.typing import NDArray


def odometry() -> tuple[float, float, float, float, float]:
    """Return the odometry: x, y, yaw, v, w."""
    return 0.0, 0.0, 0.0, 0.0, 0.0


def depths() -> tuple[float, NDArray[np.uint16]]:
    """Return the time and the depths of an image [s since the epoch, mm]."""
    return time.time(), np.full((480, 640), 3000, np.uint16)


def drive(_v: float, _w: float) -> None:
    """Do nothing."""
