"""Space that the rays of a scanner passed through, from its known places to the points."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.imports.maps.clouds.ground import CloudFloor
from ppaas.imports.maps.clouds.point_cloud import Coordinates, ScanOrigin
from ppaas.maps.grid import GridInfo

MOST_RAYS = 50_000
"""Largest number of rays of a scan; of more points some are taken."""

MOST_SAMPLES = 1 << 22
"""Number of places on rays that are considered at once."""


def seen_through(
    points: Coordinates, origins: Sequence[ScanOrigin], floor: CloudFloor, info: GridInfo, heights: tuple[float, float]
) -> NDArray[np.bool_]:
    """Return the cells through which rays passed at heights above the floor at which a robot is.

    Parameters
    ----------
    points : (n, 3) float32 array
    origins : sequence of ScanOrigin
    floor : CloudFloor
    info : GridInfo
        Grid around the points, not turned.
    heights : tuple of float
        Lowest and highest height [m]. Below the lowest, too, rays that end at the floor prove free space.
    """
    seen = np.zeros(info.width * info.height, np.bool_)
    for origin in origins:
        part = slice(origin.begin, origin.end, max(1, (origin.end - origin.begin) // MOST_RAYS))
        ends, above = points[part], floor.heights[part]
        under = points[part, 2] - above  # the floor below each point
        start = np.array(origin.place, np.float32)
        length = np.hypot(ends[:, 0] - start[0], ends[:, 1] - start[1])
        steps = np.ceil(length / info.resolution).astype(np.int64) + 1
        order = np.argsort(steps)
        begin = 0
        while begin < len(order):
            most = max(1, MOST_SAMPLES // int(steps[order[-1]]))
            chosen = order[begin : begin + most]
            begin += most
            count = int(steps[chosen].max())
            # Half a cell before the end: the cell of the point itself is not empty.
            reach = np.maximum(1.0 - 0.7 * info.resolution / np.maximum(length[chosen], 1e-3), 0.0).astype(np.float32)
            share = np.linspace(0.0, 1.0, count, dtype=np.float32)[:, np.newaxis] * reach
            z = start[2] + share * (ends[chosen, 2] - start[2]) - under[chosen]
            x = start[0] + share * (ends[chosen, 0] - start[0])
            y = start[1] + share * (ends[chosen, 1] - start[1])
            _mark(seen, info, (x, y), (z >= -heights[0]) & (z <= heights[1]))
    return seen.reshape(info.shape)


def _mark(
    seen: NDArray[np.bool_],
    info: GridInfo,
    place: tuple[NDArray[np.float32], NDArray[np.float32]],
    used: NDArray[np.bool_],
) -> None:
    columns = np.floor((place[0][used] - np.float32(info.origin.x)) / np.float32(info.resolution)).astype(np.int64)
    rows = np.floor((place[1][used] - np.float32(info.origin.y)) / np.float32(info.resolution)).astype(np.int64)
    inside = (columns >= 0) & (columns < info.width) & (rows >= 0) & (rows < info.height)
    seen[rows[inside] * info.width + columns[inside]] = True
