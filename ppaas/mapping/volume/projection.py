"""Projected map: the 2D occupancy grid of a voxel volume between two heights, as ``octomap_server`` publishes it."""

import math

import numpy as np

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.mapping.map_drawing import MOST_CELLS
from ppaas.mapping.volume.kernels import projection as kernels
from ppaas.mapping.volume.kernels.blocks import EDGE
from ppaas.mapping.volume.kernels.ends import MIDDLE
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from ppaas.maps.grid import UNKNOWN, GridInfo, GridMap


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
    kernels.project(*blocks.table, blocks.log_odds, corners, (lowest, above), speckles, corner, cells)
    return GridMap(cells, GridInfo(own.resolution, width, height, Pose2D(x, y, 0.0)))
