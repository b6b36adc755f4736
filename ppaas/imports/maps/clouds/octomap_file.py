"""OctoMap files as point clouds: a map that has only an octomap gets a grid, which robots need."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ppaas.imports.maps.clouds.point_cloud import PointCloud, cloud_of
from ppaas.imports.report import ImportReport
from ppaas.maps.exports.point_files import points_of_octree
from ppaas.maps.grid import GridInfo
from ppaas.maps.octomap import BINARY, FULL, parse_octomap
from ppaas.maps.octree import MIDDLE, OcTree, edges

MAGIC = (BINARY, FULL)


def read_octomap(content: bytes, report: ImportReport) -> PointCloud:
    """Return the occupied voxels of an OctoMap file as points; ``InvalidMap`` if it is damaged or has none."""
    tree = parse_octomap(content)
    points = points_of_octree(tree)
    cloud = cloud_of((points[:, 0], points[:, 1], points[:, 2]), report)
    report.taken("free voxels", f"{int((~tree.occupied).sum())} leaves of {tree.resolution:g} m and more")
    return replace(cloud, octree=tree)


def free_columns(tree: OcTree, info: GridInfo, low: float, high: float) -> NDArray[np.bool_]:
    """Return the cells whose middle is above or below the middle of a free voxel between two heights of the file [m].

    Parameters
    ----------
    tree : OcTree
    info : GridInfo
        Not turned.
    low, high : float
    """
    corners = (tree.corners[~tree.occupied].astype(np.int64) - MIDDLE) * tree.resolution
    sizes = edges(tree.depths[~tree.occupied]) * tree.resolution
    between = (corners[:, 2] + sizes > low) & (corners[:, 2] < high)
    begin = (corners[between, :2] - (info.origin.x, info.origin.y)) / info.resolution
    end = begin + (sizes[between] / info.resolution)[:, np.newaxis]
    most = (info.width, info.height)
    first, last = (np.clip(np.ceil(each - 0.5 - 1e-6), 0, most).astype(np.int64) for each in (begin, end))
    # Each square adds 1 at its corner and takes it off beside and above itself.
    changes = np.zeros((info.height + 1, info.width + 1), np.int64)
    for rows, columns, value in ((first, first, 1), (last, last, 1), (first, last, -1), (last, first, -1)):
        np.add.at(changes, (rows[:, 1], columns[:, 0]), value)
    return np.asarray(changes.cumsum(axis=0).cumsum(axis=1)[:-1, :-1] > 0)
