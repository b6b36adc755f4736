"""Exports of a voxel volume: octrees and OctoMap files as OctoMap makes them, and the 2D map of ``octomap_server``."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.mapping.map_drawing import MOST_CELLS
from ppaas.mapping.volume.blocks import VoxelBlocks
from ppaas.mapping.volume.kernels import leaves, projection
from ppaas.mapping.volume.kernels.blocks import EDGE, VOXELS
from ppaas.mapping.volume.kernels.ends import MIDDLE
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from ppaas.maps.grid import UNKNOWN, GridInfo, GridMap
from ppaas.maps.octomap import binary_octomap, full_octomap
from ppaas.maps.octree import OcTree, morton_codes

# -- octrees and OctoMap files -----------------------------------------------------------------------------------------


def octree_of_volume(volume: VoxelVolume) -> OcTree:
    """Return the octree of a volume, in which a voxel is occupied or free; eight equal siblings are merged."""
    corners, depths, values = _leaves(volume.blocks, by_occupancy=True)
    return OcTree(volume.parameters.resolution, corners, depths, values > 0.0)


def binary_file(volume: VoxelVolume) -> bytes:
    """Return the binary OctoMap file (``.bt``) of a volume, as ``writeBinary`` writes it."""
    return binary_octomap(octree_of_volume(volume))


def full_file(volume: VoxelVolume) -> bytes:
    """Return the full OctoMap file (``.ot``) of a volume with all log-odds, as ``write`` writes it."""
    corners, depths, values = _leaves(volume.blocks, by_occupancy=False)
    return full_octomap(OcTree(volume.parameters.resolution, corners, depths, values >= 0.0), values)


def _leaves(
    blocks: VoxelBlocks, *, by_occupancy: bool
) -> tuple[NDArray[np.uint16], NDArray[np.uint8], NDArray[np.float32]]:
    """Return the corners, depths and values of the leaves, in depth-first order."""
    begins = blocks.corners
    slots = np.argsort(morton_codes(begins))
    voxels = np.arange(VOXELS)
    order = np.argsort(morton_codes(np.stack([voxels % EDGE, voxels // EDGE % EDGE, voxels // EDGE**2], axis=1)))
    most = int(np.count_nonzero(~np.isnan(blocks.log_odds)))
    corners, depths, values = np.empty((most, 3), np.uint16), np.empty(most, np.uint8), np.empty(most, np.float32)
    count = leaves.merge_leaves(begins[slots], slots, order, blocks.log_odds, by_occupancy, corners, depths, values)
    return corners[:count].copy(), depths[:count].copy(), values[:count].copy()


# -- projected map -----------------------------------------------------------------------------------------------------


def project_volume(volume: VoxelVolume) -> GridMap:
    """Return the 2D map of a volume: a cell is occupied below any occupied voxel, else free below any free voxel.

    Voxels count that are at least partly between ``occupancy_min_z`` and ``occupancy_max_z``. The grid holds all blocks
    of the volume, and the rectangle of ``min_x_size`` × ``min_y_size`` around the origin.

    Raises
    ------
    InvalidMap
        The volume is empty, or the map would be too large.
    """
    blocks, own = volume.blocks, volume.parameters
    if not len(blocks):
        raise InvalidMap("the volume is empty: insert a point cloud first")
    corners = blocks.corners
    half = np.minimum(np.ceil(np.array([own.min_x_size, own.min_y_size]) * 0.5 / own.resolution), MIDDLE)
    first = np.minimum(corners[:, :2].min(axis=0), MIDDLE - half.astype(np.int64))
    end = np.maximum(corners[:, :2].max(axis=0) + EDGE, MIDDLE + half.astype(np.int64))
    width, height = (end - first).tolist()
    if width * height > MOST_CELLS:
        raise InvalidMap(
            f"the projected map would have {width} × {height} cells, and at most {MOST_CELLS} are allowed: choose a "
            "coarser resolution or a smaller min_x_size and min_y_size"
        )
    x, y = ((first - MIDDLE) * own.resolution).tolist()
    cells = np.full((height, width), UNKNOWN, np.int8)
    lowest = math.floor(own.occupancy_min_z / own.resolution + 1e-6) + MIDDLE
    above = math.ceil(own.occupancy_max_z / own.resolution - 1e-6) + MIDDLE
    speckles = not own.filter_speckles
    corner = (int(first[0]), int(first[1]))
    projection.project(*blocks.table, blocks.log_odds, corners, (lowest, above), speckles, corner, cells)
    return GridMap(cells, GridInfo(own.resolution, width, height, Pose2D(x, y, 0.0)))
