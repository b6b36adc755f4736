"""Occupancy grids drawn from key frames: a cell is occupied if enough of the beams that reach it end there.

Source: the occupancy grid of Karto, with its parameters ``min_pass_through`` and ``occupancy_threshold``.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping.kernels import occupancy as kernels
from ppaas.mapping.key_frames import KeyFrames
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from ppaas.planar_poses import PoseArray

MARGIN = 2
"""Cells around the outermost points."""

MOST_CELLS = 1 << 26
"""Largest map: 8192 × 8192 [cells], of 5 bytes each while it is drawn."""


class DrawingSettings(NamedTuple):
    """Settings of a map.

    Parameters
    ----------
    resolution : float
        Edge of a cell [m].
    min_pass_through : int
        Least number of beams that pass or end in a cell; it is unknown with fewer.
    occupancy_threshold : float
        Least part of these beams that end in an occupied cell.
    """

    resolution: float = 0.05
    min_pass_through: int = 2
    occupancy_threshold: float = 0.1


DEFAULTS = DrawingSettings()


def draw_map(key_frames: KeyFrames, poses: PoseArray, settings: DrawingSettings = DEFAULTS) -> GridMap:
    """Return the occupancy grid of all key frames; its axes are those of the map frame.

    Parameters
    ----------
    key_frames : KeyFrames
        Scans of the map; at least one.
    poses : (k, 3) array
        Poses of the laser in the map frame: x, y [m], theta [rad].
    settings : DrawingSettings
        Resolution and thresholds.

    Raises
    ------
    QuotaExceeded
        The map would have more than `MOST_CELLS` cells.
    """
    info = _extent(key_frames, poses, settings.resolution)
    ended, passed = np.zeros(info.shape, np.uint16), np.zeros(info.shape, np.uint16)
    kernels.count_beams(
        ended, passed, info.origin.x, info.origin.y, info.resolution, poses, key_frames.points, key_frames.valid
    )
    return GridMap(occupancy(ended, passed, settings), info)


def occupancy(
    ended: NDArray[np.uint16], passed: NDArray[np.uint16], settings: DrawingSettings = DEFAULTS
) -> NDArray[np.int8]:
    """Return the occupancy of cells.

    Parameters
    ----------
    ended, passed : (h, w) uint16 array
        Numbers of beams that end in each cell, and that pass it.
    settings : DrawingSettings
        Thresholds.

    Returns
    -------
    (h, w) int8 array
        `OCCUPIED`, `FREE` or `UNKNOWN`.
    """
    beams = passed.astype(np.float32) + ended
    cells = np.where(ended >= settings.occupancy_threshold * beams, np.int8(OCCUPIED), np.int8(FREE))
    cells[beams < settings.min_pass_through] = UNKNOWN
    return cells


def _extent(key_frames: KeyFrames, poses: PoseArray, resolution: float) -> GridInfo:
    """Return the smallest grid around all points, whose corner is a multiple of the resolution."""
    x0, y0, x1, y1 = kernels.bounds(poses, key_frames.points, key_frames.valid)
    left, bottom = math.floor(x0 / resolution) - MARGIN, math.floor(y0 / resolution) - MARGIN
    width = math.floor(x1 / resolution) + MARGIN + 1 - left
    height = math.floor(y1 / resolution) + MARGIN + 1 - bottom
    if width * height > MOST_CELLS:
        raise QuotaExceeded(
            f"the map would have {width} × {height} cells, and at most {MOST_CELLS} are allowed: "
            "choose a coarser resolution or a smaller max_laser_range"
        )
    return GridInfo(resolution, width, height, Pose2D(left * resolution, bottom * resolution, 0.0))
