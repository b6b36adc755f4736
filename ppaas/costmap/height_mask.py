"""What of a map in space is in the way of a robot of some height, as a mask of where it is to keep out."""

import math

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED, GridInfo, GridMap
from ppaas.maps.kernels.octree import fill_cubes
from ppaas.maps.octree import DEPTH, MIDDLE, OcTree, edges

_SLACK = 1e-6
"""What only touches is not hit, though its height was rounded; in voxels."""


def height_mask(tree: OcTree, info: GridInfo, *, lowest: float | None, highest: float) -> GridMap:
    """Return where something occupied reaches into the heights of a robot: 100 there, else 0.

    Parameters
    ----------
    tree : OcTree
        In the frame of the map, whose floor is at z = 0. What it does not know is in nobody's way.
    info : GridInfo
        Of the map, which is looked at as far as it reaches.
    lowest, highest : float
        From where on and up to where something is in the way [m]; by default from one voxel of the octree on, since the
        floor in a map is as rough.

    Returns
    -------
    GridMap
        Its cells are columns of the octree, as wide as there are that are no wider than a cell of the map; those of the
        octree's finest voxels where these are wider.
    """
    finer = math.floor(math.log2(info.resolution) - math.log2(tree.resolution) + _SLACK)
    size = 1 << min(max(finer, 0), DEPTH)
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
    """Return the columns of this width [m] that begin at whole multiples of it and hold all of a map.

    An octree has so many from 0 m to each side.
    """
    far = info.width * info.resolution, info.height * info.resolution
    ends = [(info.origin @ Pose2D(x, y))[:2] for x in (0.0, far[0]) for y in (0.0, far[1])]
    low = np.clip(np.floor(np.min(ends, axis=0) / width), -reach, reach).astype(np.int64)
    high = np.clip(np.ceil(np.max(ends, axis=0) / width), -reach, reach).astype(np.int64)
    columns, rows = np.maximum(high - low, 1).tolist()
    return GridInfo(width, columns, rows, Pose2D(*(low * width).tolist()))
