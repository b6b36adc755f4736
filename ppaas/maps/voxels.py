"""Voxel grids, the three-dimensional occupancy grids, and their geometry in the map frame."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.errors import InvalidInput, InvalidMap

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

    def cropped(self, low: ArrayLike, high: ArrayLike) -> "VoxelGrid":
        """Return the whole voxels between two corners.

        Parameters
        ----------
        low, high : (3,) array
            Opposite corners, x, y, z [m]; may be outside the map.

        Raises
        ------
        InvalidInput
            No part of the map is between the corners, or they are not three numbers each.
        """
        local = (corners(low, high) - self.info.origin) / self.info.resolution
        first, last = window(local, (0, 0, 0), self.info.shape[::-1])
        x, y, z = first
        data = self.data[z : last[2], y : last[1], x : last[0]].copy()
        depth, height, width = data.shape
        origin = Point3D(*(np.add(self.info.origin, np.multiply(first, self.info.resolution)).tolist()))
        return VoxelGrid(data, VoxelInfo(self.info.resolution, width, height, depth, origin))


def only_read(data: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a read-only, contiguous view for kernels that only read, so that each kernel has one signature."""
    view = np.ascontiguousarray(data).view()
    view.flags.writeable = False
    return view


def corners(low: ArrayLike, high: ArrayLike) -> NDArray[np.float64]:
    """Return two corners as a (2, 3) array.

    Raises
    ------
    InvalidInput
        A corner does not have three numbers, or one is NaN.
    """
    both = [np.asarray(corner, dtype=np.float64) for corner in (low, high)]
    if any(corner.shape != (3,) or np.isnan(corner).any() for corner in both):
        raise InvalidInput("the corners to crop a map to must be x, y, z in metres each")
    return np.stack(both)


def window(between: NDArray[np.float64], low: ArrayLike, high: ArrayLike) -> tuple[list[int], list[int]]:
    """Return the range of voxels between two corners: the first index and the one after the last, along x, y, z.

    Parameters
    ----------
    between : (2, 3) array
        The corners [voxels].
    low, high : (3,) array
        Bounds of the map [voxels], ``high`` excluded.

    Raises
    ------
    InvalidInput
        The range is empty.
    """
    first = np.clip(np.floor(between[0] + 1e-6), low, high).astype(np.int64)
    last = np.clip(np.ceil(between[1] - 1e-6), low, high).astype(np.int64)
    if not (first < last).all():
        raise InvalidInput("no part of the map is between the corners: give them in the map frame, the lower one first")
    return first.tolist(), last.tolist()
