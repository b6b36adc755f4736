"""Octrees and OctoMap files of a voxel volume, equal to those that OctoMap makes from the same clouds."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.volume.blocks import VoxelBlocks
from ppaas.mapping.volume.kernels import leaves as kernels
from ppaas.mapping.volume.kernels.blocks import EDGE, VOXELS
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from ppaas.maps.octomap import binary_octomap, full_octomap
from ppaas.maps.octree import OcTree, morton_codes


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
    count = kernels.merge_leaves(begins[slots], slots, order, blocks.log_odds, by_occupancy, corners, depths, values)
    return corners[:count].copy(), depths[:count].copy(), values[:count].copy()
