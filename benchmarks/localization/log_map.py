"""Map from scans with known poses: cells that rays cross are free, and cells where many rays end are walls."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.localization.beams import scan_points
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from robots.recordings.recording import Look

RESOLUTION = 0.05
FARTHEST = 20.0
"""Maximum range of scans [m]."""
OFTEN = 0.25
"""Share of the rays at a cell that must end in it for a wall, as in gmapping."""
MARGIN = 1.0
"""Margin around the endpoints of all rays [m]."""
MOST_CELLS = 1 << 26
"""Largest number of cells of a map."""


def map_of(looks: Sequence[Look]) -> GridMap:
    """Return the map of some scans.

    Parameters
    ----------
    looks : sequence of Look
        Scans with their true poses.

    Raises
    ------
    InvalidInput
        No scan has a hit, the map would be too large, or a true pose is unknown.
    """
    rays = []
    for look in looks:
        if look.true is None:
            raise InvalidInput("the recording has no true poses from which a map could be made: give --map")
        eye = look.true @ look.laser
        ends = scan_points(look.scan, eye)
        near = np.hypot(*(ends - (eye.x, eye.y)).T) < FARTHEST
        rays.append((eye, ends[near]))
    info = _size(np.concatenate([ends for _, ends in rays]))
    ended, passed = (np.zeros(info.width * info.height, np.int32) for _ in range(2))
    for eye, ends in rays:
        ended[_cells(ends, info)] += 1
        passed[_cells(_along(eye, ends), info)] += 1
    cells = np.where(ended + passed == 0, UNKNOWN, np.where(ended > OFTEN * (ended + passed), OCCUPIED, FREE))
    return GridMap(cells.astype(np.int8).reshape(info.height, info.width), info)


def _size(ends: NDArray[np.float64]) -> GridInfo:
    if not len(ends):
        raise InvalidInput("the scans of the recording hit nothing, so no map can be made of them: give --map")
    low, high = ends.min(axis=0) - MARGIN, ends.max(axis=0) + MARGIN
    width, height = (math.ceil(extent / RESOLUTION) for extent in (high - low).tolist())
    if width * height > MOST_CELLS:
        raise InvalidInput(f"a map of {width} × {height} cells is too large: give --map")
    return GridInfo(RESOLUTION, width, height, Pose2D(float(low[0]), float(low[1])))


def _along(eye: Pose2D, ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (n, 2) points along the rays, half a cell apart, up to one cell before their endpoints."""
    gaps = ends - (eye.x, eye.y)
    lengths = np.hypot(*gaps.T)
    counts = np.maximum(np.floor((lengths - RESOLUTION) / (RESOLUTION / 2.0)), 0.0).astype(np.int64)
    ray = np.repeat(np.arange(len(ends)), counts)
    number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    points: NDArray[np.float64] = (eye.x, eye.y) + gaps[ray] * (number * (RESOLUTION / 2.0) / lengths[ray])[:, None]
    return points


def _cells(points: NDArray[np.float64], info: GridInfo) -> NDArray[np.int64]:
    """Return the indices of the cells that contain points, without duplicates."""
    column, row = np.floor((points - (info.origin.x, info.origin.y)) / info.resolution).astype(np.int64).T
    inside = (column >= 0) & (column < info.width) & (row >= 0) & (row < info.height)
    return np.unique(row[inside] * info.width + column[inside])
