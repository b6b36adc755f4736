"""Voxel grids and where their voxels lie in the world: occupancy grids with one dimension more."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.errors import InvalidInput, InvalidMap

FREE = 0
OCCUPIED = 100
UNKNOWN = 255
"""−1 of an occupancy grid, read as a byte."""

MAX_VOXELS = 1 << 28

Voxel = tuple[int, int, int]
"""Layer, row, column: along z, y and x."""


class Point3D(NamedTuple):
    """x, y, z [m]."""

    x: float
    y: float
    z: float


ORIGIN = Point3D(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class VoxelInfo:
    """Where a voxel grid lies in the world; its axes are those of the map frame.

    Parameters
    ----------
    resolution : float
        Edge of a voxel [m].
    width, height, depth : int
        Voxels along x, along y and along z.
    origin : Point3D
        The corner of voxel (0, 0, 0) with the least x, y and z [m].

    Raises
    ------
    InvalidMap
        A resolution that is not positive, a grid without voxels or with too many, an origin that is not finite.
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
                f"a voxel grid has from 1 to {MAX_VOXELS} voxels, not {self.width}×{self.height}×{self.depth}: "
                "crop the map, or read it at a coarser depth"
            )
        if not all(map(math.isfinite, self.origin)):
            raise InvalidMap(f"the origin must be finite, not {tuple(self.origin)}")

    @property
    def shape(self) -> Voxel:
        """(depth, height, width): the shape of the arrays, layer 0 at the bottom."""
        return self.depth, self.height, self.width

    def to_voxels(self, points: ArrayLike) -> NDArray[np.int64]:
        """Return the voxels in which points lie: (..., 3) layer, row, column of (..., 3) x, y, z [m]."""
        local = (np.asarray(points, dtype=np.float64) - self.origin) / self.resolution
        return np.floor(local[..., ::-1]).astype(np.int64)

    def to_world(self, voxels: ArrayLike) -> NDArray[np.float64]:
        """Return the centres of voxels, (..., 3) x, y, z [m], from (..., 3) layer, row, column."""
        centres = (np.asarray(voxels, dtype=np.float64)[..., ::-1] + 0.5) * self.resolution + self.origin
        return np.asarray(centres)


@dataclass(frozen=True, slots=True)
class VoxelGrid:
    """What is known of each voxel.

    Parameters
    ----------
    data : (depth, height, width) uint8 array
        0 free, 100 occupied, 255 unknown; layer 0 is the lowest. Not written to.
    info : VoxelInfo
        Where it lies.

    Raises
    ------
    InvalidMap
        An array of another shape, type or with other values.
    """

    data: NDArray[np.uint8]
    info: VoxelInfo

    def __post_init__(self) -> None:
        if self.data.shape != self.info.shape or self.data.dtype != np.uint8:
            raise InvalidMap(
                f"expected uint8 voxels of shape {self.info.shape}, got {self.data.dtype} of {self.data.shape}"
            )
        known = (self.data == FREE) | (self.data == OCCUPIED) | (self.data == UNKNOWN)
        if not known.all():
            raise InvalidMap(
                f"a voxel is {FREE} (free), {OCCUPIED} (occupied) or {UNKNOWN} (unknown), not {self.data[~known][0]}"
            )

    def cropped(self, low: ArrayLike, high: ArrayLike) -> "VoxelGrid":
        """Return what lies between two corners, in whole voxels.

        Parameters
        ----------
        low, high : (3,) array
            x, y, z [m]; may lie outside.

        Raises
        ------
        InvalidInput
            Nothing of the map lies between them, or they are no corners.
        """
        local = (corners(low, high) - self.info.origin) / self.info.resolution
        first, last = window(local, (0, 0, 0), self.info.shape[::-1])
        x, y, z = first
        data = self.data[z : last[2], y : last[1], x : last[0]].copy()
        depth, height, width = data.shape
        origin = Point3D(*(np.add(self.info.origin, np.multiply(first, self.info.resolution)).tolist()))
        return VoxelGrid(data, VoxelInfo(self.info.resolution, width, height, depth, origin))


def only_read(data: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a view of an array for a kernel that only reads it, so that each is compiled once for all arrays."""
    view = np.ascontiguousarray(data).view()
    view.flags.writeable = False
    return view


def corners(low: ArrayLike, high: ArrayLike) -> NDArray[np.float64]:
    """Return two corners as a (2, 3) array.

    Raises
    ------
    InvalidInput
        They are not three numbers each, or not numbers at all.
    """
    both = [np.asarray(corner, dtype=np.float64) for corner in (low, high)]
    if any(corner.shape != (3,) or np.isnan(corner).any() for corner in both):
        raise InvalidInput("a map is cropped to two corners, each x, y, z [m]")
    return np.stack(both)


def window(between: NDArray[np.float64], low: ArrayLike, high: ArrayLike) -> tuple[list[int], list[int]]:
    """Return the first whole voxels between two corners and those after the last, x, y, z.

    Parameters
    ----------
    between : (2, 3) array
        In voxels.
    low, high : (3,) array
        Bounds of all voxels, ``high`` excluded.

    Raises
    ------
    InvalidInput
        There are none.
    """
    first = np.clip(np.floor(between[0] + 1e-6), low, high).astype(np.int64)
    last = np.clip(np.ceil(between[1] - 1e-6), low, high).astype(np.int64)
    if not (first < last).all():
        raise InvalidInput("nothing of the map lies between the corners; give them in its frame, the lower one first")
    return first.tolist(), last.tolist()
