"""Voxel grids, the three-dimensional occupancy grids, and their geometry in the map frame."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.errors import InvalidMap

FREE = 0
OCCUPIED = 100
UNKNOWN = 255
"""The −1 of an occupancy grid, as an unsigned byte."""

MAX_VOXELS = 1 << 28

Voxel = tuple[int, int, int]
"""(layer, row, column): indices along z, y and x."""


class Point3D(NamedTuple):
    """Point in space, x, y, z [m]."""

    x: float
    y: float
    z: float


ORIGIN = Point3D(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class VoxelInfo:
    """Geometry of a voxel grid, whose axes are the map frame's.

    Parameters
    ----------
    resolution : float
        Edge of a voxel [m].
    width, height, depth : int
        Numbers of voxels along x, y and z.
    origin : Point3D
        Corner of voxel (0, 0, 0) with the least x, y and z [m].

    Raises
    ------
    InvalidMap
        The resolution is not positive, the grid has no voxels or too many, or the origin is not finite.
    """

    resolution: float
    width: int
    height: int
    depth: int
    origin: Point3D = ORIGIN

    def __post_init__(self) -> None:
        if not (math.isfinite(self.resolution) and self.resolution > 0.0):
            raise InvalidMap(f"resolution must be a positive number of metres, not {self.resolution}")
        count = self.width * self.height * self.depth
        if min(self.shape) < 1 or count > MAX_VOXELS:
            raise InvalidMap(
                f"a voxel grid must have from 1 to {MAX_VOXELS} voxels, not {self.width}×{self.height}×{self.depth}: "
                "crop the map, or read it at a coarser depth"
            )
        if not all(map(math.isfinite, self.origin)):
            raise InvalidMap(f"origin must be finite, not {tuple(self.origin)}")

    @property
    def shape(self) -> Voxel:
        """Shape of the arrays, (depth, height, width); layer 0 is the lowest."""
        return self.depth, self.height, self.width

    def to_voxels(self, points: ArrayLike) -> NDArray[np.int64]:
        """Return the voxels that contain points: (..., 3) layer, row, column from (..., 3) x, y, z [m]."""
        local = (np.asarray(points, dtype=np.float64) - self.origin) / self.resolution
        return np.floor(local[..., ::-1]).astype(np.int64)

    def to_world(self, voxels: ArrayLike) -> NDArray[np.float64]:
        """Return the centres of voxels: (..., 3) x, y, z [m] from (..., 3) layer, row, column."""
        centres = (np.asarray(voxels, dtype=np.float64)[..., ::-1] + 0.5) * self.resolution + self.origin
        return np.asarray(centres)


@dataclass(frozen=True, slots=True)
class VoxelGrid:
    """Occupancy grid in space.

    Parameters
    ----------
    data : (depth, height, width) uint8 array
        0 free, 100 occupied, 255 unknown; layer 0 is the lowest. Never modified.
    info : VoxelInfo
        Geometry of the grid.

    Raises
    ------
    InvalidMap
        The array has another shape or type, or other values.
    """

    data: NDArray[np.uint8]
    info: VoxelInfo

    def __post_init__(self) -> None:
        if self.data.shape != self.info.shape or self.data.dtype != np.uint8:
            raise InvalidMap(
                f"expected uint8 voxels of shape {self.info.shape}, not {self.data.dtype} of shape {self.data.shape}"
            )
        valid = (self.data == FREE) | (self.data == OCCUPIED) | (self.data == UNKNOWN)
        if not valid.all():
            values = f"{FREE} (free), {OCCUPIED} (occupied) or {UNKNOWN} (unknown)"
            raise InvalidMap(f"a voxel must be {values}, not {self.data[~valid][0]}")


def only_read(data: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a read-only, contiguous view for kernels that only read, so that each kernel has one signature."""
    view = np.ascontiguousarray(data).view()
    view.flags.writeable = False
    return view
