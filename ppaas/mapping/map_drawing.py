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
    """Return the occupancy grid of all key frames; its axes are the map frame's.

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
    count_beams((ended, passed), info, poses, key_frames.points, key_frames.valid)
    return GridMap(occupancy(ended, passed, settings), info)


def bounds(
    poses: PoseArray, points: NDArray[np.float32], valid: NDArray[np.bool_]
) -> tuple[float, float, float, float]:
    """Return the least x and y and the greatest x and y [m] of all poses, points and free beams; see `count_beams`."""
    found: tuple[float, float, float, float] = kernels.bounds(poses, points, valid | _open_beams(points, valid))
    return found


def count_beams(
    counts: tuple[NDArray[np.uint16], NDArray[np.uint16]],
    info: GridInfo,
    poses: PoseArray,
    points: NDArray[np.float32],
    valid: NDArray[np.bool_],
) -> None:
    """Count the beams of key frames in the cells that they pass and in those that they end in.

    Parameters
    ----------
    counts : tuple of (h, w) uint16 array
        Modified: numbers of beams that end in each cell, and that pass it.
    info : GridInfo
        Their geometry; its axes are the map frame's, and all beams lie in it.
    poses : (k, 3) array
        Poses of the laser in the map frame: x, y [m], theta [rad].
    points : (k, b, 2) float32 array
        Ends of the beams, each in the frame of its laser [m].
    valid : (k, b) bool array
        Whether the beam has a reading. One without is free up to its point, unless that is 0: it ends in no cell.
    """
    (ended, passed), (x0, y0, _), resolution = counts, info.origin, info.resolution
    kernels.count_beams(ended, passed, x0, y0, resolution, poses, points, valid)
    is_open = _open_beams(points, valid)
    chosen = np.flatnonzero(is_open.any(axis=1))
    if not len(chosen):
        return
    poses, points, is_open = poses[chosen], points[chosen], is_open[chosen]
    low_x, low_y, high_x, high_y = kernels.bounds(poses, points, is_open)
    column, row = int((low_x - x0) / resolution), int((low_y - y0) / resolution)
    window = slice(row, int((high_y - y0) / resolution) + 1), slice(column, int((high_x - x0) / resolution) + 1)
    ends, passes = (np.zeros(passed[window].shape, np.uint16) for _ in range(2))
    corner = x0 + column * resolution, y0 + row * resolution
    kernels.count_beams(ends, passes, *corner, resolution, poses, points, is_open)
    room = np.iinfo(np.uint16).max - passed[window]
    passed[window] += np.minimum(passes, room)


def _open_beams(points: NDArray[np.float32], valid: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which beams without a reading are free up to their points."""
    found: NDArray[np.bool_] = ~valid & points.any(axis=-1)
    return found


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
    x0, y0, x1, y1 = bounds(poses, key_frames.points, key_frames.valid)
    left, bottom = math.floor(x0 / resolution) - MARGIN, math.floor(y0 / resolution) - MARGIN
    width = math.floor(x1 / resolution) + MARGIN + 1 - left
    height = math.floor(y1 / resolution) + MARGIN + 1 - bottom
    if width * height > MOST_CELLS:
        raise QuotaExceeded(
            f"the map would have {width} × {height} cells, and at most {MOST_CELLS} are allowed: "
            "choose a coarser resolution or a smaller max_laser_range"
        )
    return GridInfo(resolution, width, height, Pose2D(left * resolution, bottom * resolution, 0.0))
