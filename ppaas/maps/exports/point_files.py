"""Obstacles of a map as point clouds: PCD and PLY in binary, and text."""

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridMap
from ppaas.maps.octree import MIDDLE, OcTree, edges

MOST_POINTS = 50_000_000
"""Largest number of points of a file."""

Places = NDArray[np.float32]
"""(n, 3): x, y, z [m]."""


def points_of_octree(tree: OcTree) -> Places:
    """Return the middles of the finest voxels of all occupied leaves.

    Raises
    ------
    InvalidMap
        There are none, or too many.
    """
    corners, sizes = tree.corners[tree.occupied].astype(np.int64), edges(tree.depths[tree.occupied])
    count = int((sizes**3).sum())
    _check(count)
    parts = []
    for size in np.unique(sizes).tolist():
        inner = np.stack(np.meshgrid(*(np.arange(size),) * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        parts.append((corners[sizes == size][:, np.newaxis] + inner).reshape(-1, 3))
    return ((np.concatenate(parts) - MIDDLE + 0.5) * tree.resolution).astype(np.float32)


def points_of_grid(grid: GridMap) -> Places:
    """Return the middles of all occupied cells, at the height 0; raises as `points_of_octree`."""
    cells = np.argwhere(grid.data >= OCCUPIED_THRESHOLD)
    _check(len(cells))
    places = np.zeros((len(cells), 3), np.float32)
    places[:, :2] = grid.info.to_world(cells)
    return places


def pcd_file(points: Places) -> bytes:
    """Return points as binary PCD."""
    count = len(points)
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
        f"WIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA binary\n"
    )
    return header.encode() + points.astype("<f4").tobytes()


def ply_file(points: Places) -> bytes:
    """Return points as binary PLY."""
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n"
    )
    return header.encode() + points.astype("<f4").tobytes()


def xyz_file(points: Places) -> bytes:
    """Return points as text, a point in each row."""
    return "".join(f"{x:.4f} {y:.4f} {z:.4f}\n" for x, y, z in points.tolist()).encode()


def _check(count: int) -> None:
    if not 1 <= count <= MOST_POINTS:
        raise InvalidMap(f"the map has {count} occupied points; a cloud has from 1 to {MOST_POINTS}")
