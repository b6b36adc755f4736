"""Voxel grids and costmaps in space for tests, drawn at random or built from blocks."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from ppaas.costmap.voxels import VoxelCostmap
from ppaas.maps.voxels import FREE, OCCUPIED, ORIGIN, UNKNOWN, Point3D, Voxel, VoxelGrid, VoxelInfo
from ppaas.planners.volume import Pose3D


def info_of(data: NDArray[np.uint8], resolution: float = 1.0, origin: Point3D = ORIGIN) -> VoxelInfo:
    """Return the geometry of an array's voxel grid."""
    depth, height, width = data.shape
    return VoxelInfo(resolution, width, height, depth, origin)


def grid(data: NDArray[np.uint8], resolution: float = 1.0, origin: Point3D = ORIGIN) -> VoxelGrid:
    """Return the voxel grid of an array."""
    return VoxelGrid(data, info_of(data, resolution, origin))


def costmap(data: NDArray[np.uint8], resolution: float = 1.0, origin: Point3D = ORIGIN) -> VoxelCostmap:
    """Return the costmap of an array."""
    return VoxelCostmap(data, info_of(data, resolution, origin))


def place(costs: VoxelCostmap, voxel: Voxel, theta: float = 0.0) -> Pose3D:
    """Return the pose at the position that a voxel represents."""
    x, y, z = costs.places(voxel).tolist()
    return Pose3D(x, y, z, theta)


def cost_arrays(most: int = 5) -> st.SearchStrategy[NDArray[np.uint8]]:
    """Draw small arrays of costs in which free, graded, blocked and unknown voxels are all common."""
    values = st.one_of(st.sampled_from([0, 0, 0, 0, 1, 128, 252, 253, 254, 255]), st.integers(0, 255))
    return hnp.arrays(np.uint8, st.tuples(*[st.integers(1, most)] * 3), elements=values)


def grid_arrays(most: int = 6) -> st.SearchStrategy[NDArray[np.uint8]]:
    """Draw small arrays of voxels, most of them free."""
    values = st.sampled_from([FREE] * 8 + [OCCUPIED, UNKNOWN])
    return hnp.arrays(np.uint8, st.tuples(*[st.integers(1, most)] * 3), elements=values)


def free_voxels(costs: NDArray[np.uint8], allow_unknown: bool) -> list[Voxel]:
    """Return the voxels that paths may pass."""
    free = (costs < 253) | ((costs == 255) & allow_unknown)
    return [(layer, row, column) for layer, row, column in np.argwhere(free).tolist()]


def room(length: float = 4.0, width: float = 3.0, height: float = 2.0, resolution: float = 0.1) -> VoxelGrid:
    """Return a room whose floor, ceiling and walls are one voxel thick; its floor is at z = 0."""
    shape = [round(size / resolution) + 2 for size in (height, width, length)]
    data = np.full(shape, OCCUPIED, np.uint8)
    data[1:-1, 1:-1, 1:-1] = FREE
    return grid(data, resolution, Point3D(-resolution, -resolution, -resolution))


def put(scene: VoxelGrid, low: tuple[float, float, float], high: tuple[float, float, float]) -> None:
    """Add a block between two corners, x, y, z [m], to a scene."""
    first, last = (np.rint(np.subtract(corner, scene.info.origin) / scene.info.resolution).astype(int)[::-1]
                   for corner in (low, high))  # fmt: skip
    scene.data[first[0] : last[0], first[1] : last[1], first[2] : last[2]] = OCCUPIED
