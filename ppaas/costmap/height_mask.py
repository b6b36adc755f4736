"""Keep-out mask of the obstacles of a map in space at the heights of a robot."""

import math

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED, GridInfo, GridMap
from ppaas.maps.kernels.octree import fill_cubes
from ppaas.maps.octree import DEPTH, MIDDLE, OcTree, edges

_SLACK = 1e-6
"""Tolerance for rounded heights, so that touching does not count as overlap [voxels]."""


def height_mask(tree: OcTree, info: GridInfo, *, lowest: float | None, highest: float) -> GridMap:
    """Return a mask that is 100 where an occupied voxel overlaps the heights of a robot, and 0 elsewhere.

    Parameters
    ----------
    tree : OcTree
        Map in space, in the frame of the map, whose floor is at z = 0. Unknown space does not count.
    info : GridInfo
        Geometry of the map; the mask covers its extent.
    lowest, highest : float
        Range of heights in which occupied voxels count [m]. The default of ``lowest`` is the edge of one voxel of the
        octree, since the floor of a map is that rough.

    Returns
    -------
    GridMap
        Mask whose cells are columns of the octree: of the coarsest depth whose voxels are at most as wide as a cell of
        the map, or else of the finest depth.
    """
    levels = math.floor(math.log2(info.resolution) - math.log2(tree.resolution) + _SLACK)
    size = 1 << min(max(levels, 0), DEPTH)  # width of a column [finest voxels]
    columns = _columns(info, size * tree.resolution, MIDDLE // size)
    first = np.rint(np.array(columns.origin[:2]) / columns.resolution).astype(np.int64)
    slack = _SLACK * tree.resolution
    keys = tree.corners[tree.occupied].astype(np.int64) - MIDDLE
    widths = edges(tree.depths[tree.occupied])
    bottom, top = keys[:, 2] * tree.resolution, (keys[:, 2] + widths) * tree.resolution
    floor = tree.resolution if lowest is None else lowest
    hit = (top > floor + slack) & (bottom < highest - slack)
    begins = np.zeros((int(hit.sum()), 3), np.int64)
    begins[:, :2] = keys[hit, :2] // size - first
    data = np.zeros(columns.shape, np.uint8)
    fill_cubes(data[None], begins, np.maximum(widths[hit] // size, 1), np.full(len(begins), OCCUPIED, np.uint8))
    return GridMap(data.view(np.int8), columns)


def _columns(info: GridInfo, width: float, reach: int) -> GridInfo:
    """Return the grid of columns that covers a map.

    Parameters
    ----------
    info : GridInfo
        Geometry of the map.
    width : float
        Width of a column [m]; columns begin at multiples of it.
    reach : int
        Number of columns that the octree has from 0 m to each side, which limits the grid.
    """
    far = info.width * info.resolution, info.height * info.resolution
    ends = [(info.origin @ Pose2D(x, y))[:2] for x in (0.0, far[0]) for y in (0.0, far[1])]
    low = np.clip(np.floor(np.min(ends, axis=0) / width), -reach, reach).astype(np.int64)
    high = np.clip(np.ceil(np.max(ends, axis=0) / width), -reach, reach).astype(np.int64)
    columns, rows = np.maximum(high - low, 1).tolist()
    return GridInfo(width, columns, rows, Pose2D(*(low * width).tolist()))
