"""Occupancy octrees, as in OctoMap: uniform regions are stored as few large cubes.

Source: Hornung, Wurm, Bennewitz, Stachniss, Burgard, "OctoMap: An Efficient Probabilistic 3D Mapping Framework Based on
Octrees", Autonomous Robots, 2013. A key is an integer from 0 to 65535 along each axis, in voxels of the finest depth,
16; key 32768 begins at 0 m.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.maps.kernels.octree import fill_cubes
from ppaas.maps.voxels import FREE, OCCUPIED, UNKNOWN, Point3D, VoxelGrid, VoxelInfo

DEPTH = 16
"""Depth of the finest voxels; the root has depth 0."""

MIDDLE = 1 << (DEPTH - 1)
"""Key at 0 m."""

Keys = NDArray[np.uint16]


@dataclass(frozen=True, slots=True)
class OcTree:
    """Leaves of an octree, in depth-first order.

    Parameters
    ----------
    resolution : float
        Edge of the finest voxels [m].
    corners : (n, 3) uint16 array
        Least key of each leaf along x, y and z.
    depths : (n,) uint8 array
        Depth of each leaf; a leaf of depth d is a cube with an edge of 2^(16 − d) voxels.
    occupied : (n,) bool array
        Whether each leaf is occupied, else it is free. Space without a leaf is unknown.
    """

    resolution: float
    corners: Keys
    depths: NDArray[np.uint8]
    occupied: NDArray[np.bool_]

    @property
    def nodes(self) -> int:
        """Number of nodes including the root and inner nodes; 0 if the tree is empty."""
        return int((self.depths - shared_depths(self.corners)).sum()) + 1 if len(self.corners) else 0

    def bounds(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the bounds of all leaves, least keys and greatest keys plus one, along x, y and z.

        Raises
        ------
        InvalidMap
            The tree is empty.
        """
        if not len(self.corners):
            raise InvalidMap("the octree is empty: all its voxels are unknown")
        begins = self.corners.astype(np.int64)
        return begins.min(axis=0), (begins + edges(self.depths)[:, None]).max(axis=0)

    def at_depth(self, depth: int) -> "OcTree":
        """Return a coarser octree, whose finest voxels have the given depth.

        A coarse voxel is occupied if any part of it is occupied, and free only if all of it is known to be free.
        (OctoMap differs: it calls a coarse voxel free if no part of it is occupied and some part is free, so that a
        path through it may lead through unknown space.)

        Raises
        ------
        InvalidInput
            The depth is not from 1 to 16.
        """
        if not 1 <= depth <= DEPTH:
            raise InvalidInput(f"the depth of an octree must be from 1 to {DEPTH}, not {depth}")
        mask = np.uint16(0xFFFF << (DEPTH - depth) & 0xFFFF)  # keeps the bits of a key above the depth
        begins = self.corners & mask
        depths = np.minimum(self.depths, np.uint8(depth))
        if not len(begins):
            return OcTree(self.resolution, begins, depths, self.occupied)
        first = np.flatnonzero(np.r_[True, (begins[1:] != begins[:-1]).any(axis=1)])
        filled = np.add.reduceat(edges(self.depths) ** 3, first)
        occupied = np.logical_or.reduceat(self.occupied, first)
        kept = occupied | (filled == edges(depths[first]) ** 3)
        first = first[kept]
        return OcTree(self.resolution, begins[first], depths[first], occupied[kept])

    def voxels(self, depth: int = DEPTH, *, low: ArrayLike | None = None, high: ArrayLike | None = None) -> VoxelGrid:
        """Return the voxel grid of the tree, by default of the bounding box of all leaves.

        Parameters
        ----------
        depth : int
            16 for the finest voxels; each level less doubles the edge of a voxel, as in ``at_depth``.
        low, high : (3,) array, optional
            Opposite corners of the box to crop to, x, y, z [m].

        Raises
        ------
        InvalidMap
            The tree is empty, or the grid is too large: crop it or choose a coarser depth.
        InvalidInput
            The depth is invalid, or no part of the tree is between the corners.
        """
        tree = self.at_depth(depth)
        size = 1 << (DEPTH - depth)
        resolution = self.resolution * size
        bounds = np.stack(tree.bounds()) // size
        cut = _corners(np.full(3, -np.inf) if low is None else low, np.full(3, np.inf) if high is None else high)
        middle = MIDDLE // size
        keys = np.clip(cut / resolution + middle, bounds[0], bounds[1])
        first, last = _window(keys, bounds[0], bounds[1])
        origin = Point3D(*((key - middle) * resolution for key in first))
        width, height, layers = np.subtract(last, first).tolist()
        info = VoxelInfo(resolution, width, height, layers, origin)
        data = np.full(info.shape, UNKNOWN, np.uint8)
        begins = tree.corners.astype(np.int64) // size - first
        values = np.where(tree.occupied, np.uint8(OCCUPIED), np.uint8(FREE))
        fill_cubes(data, begins, edges(tree.depths) // size, values)
        return VoxelGrid(data, info)


def octree_of(grid: VoxelGrid) -> OcTree:
    """Return the octree of a voxel grid, in which eight equal siblings are always merged.

    Raises
    ------
    InvalidMap
        The origin is not a multiple of the resolution, or the grid exceeds the range of an octree's keys.
    """
    begin = np.divide(grid.info.origin, grid.info.resolution)
    first = np.rint(begin)
    if np.abs(begin - first).max() > 1e-3:
        raise InvalidMap(
            f"the origin of an octree must be a multiple of {grid.info.resolution:g} m, not "
            f"{tuple(grid.info.origin)}: move the origin"
        )
    known = np.argwhere(grid.data != UNKNOWN)
    occupied = grid.data[known[:, 0], known[:, 1], known[:, 2]] == OCCUPIED
    return octree_of_voxels(grid.info.resolution, known[:, ::-1] + first.astype(np.int64), occupied)


def octree_of_voxels(resolution: float, voxels: NDArray[np.int64], occupied: NDArray[np.bool_]) -> OcTree:
    """Return the octree of known voxels, in which eight equal siblings are always merged.

    Parameters
    ----------
    resolution : float
        Edge of a voxel [m].
    voxels : (n, 3) int array
        Different voxels, along x, y and z from 0 m [voxels].
    occupied : (n,) bool array
        Whether each is occupied, else it is free.

    Raises
    ------
    InvalidMap
        A voxel is out of the range of an octree's keys.
    """
    keys = voxels + MIDDLE
    if len(keys) and not (keys.min() >= 0 and keys.max() < 2 * MIDDLE):
        far = MIDDLE * resolution
        raise InvalidMap(f"an octree of this resolution reaches {far:g} m from its origin: move the map nearer to it")
    codes = morton_codes(keys)
    order = np.argsort(codes)
    return _merged(resolution, codes[order], occupied[order])


def _merged(resolution: float, codes: NDArray[np.int64], occupied: NDArray[np.bool_]) -> OcTree:
    """Merge eight equal siblings to their parent, from the finest depth up; ``codes`` are sorted Morton codes."""
    leaves = []
    for depth in range(DEPTH, 0, -1):
        merges = np.zeros(len(codes), np.bool_)
        if len(codes) > 7:
            # Eight siblings are known if eight successive codes differ in their last three bits only.
            first = np.flatnonzero((codes[:-7] & 7 == 0) & (codes[7:] - codes[:-7] == 7))
            siblings = np.add.outer(first, np.arange(8))
            count = occupied[siblings].sum(axis=1)
            merges[siblings[(count == 0) | (count == 8)].ravel()] = True
        leaves.append((codes[~merges] << 3 * (DEPTH - depth), np.full((~merges).sum(), depth), occupied[~merges]))
        codes, occupied = codes[merges][::8] >> 3, occupied[merges][::8]
    merged, depths, occupied = (np.concatenate(part) for part in zip(*leaves, strict=True))
    order = np.argsort(merged)
    return OcTree(resolution, _keys_of(merged[order]), depths[order].astype(np.uint8), occupied[order])


def edges(depths: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Return the edges of cubes of these depths [finest voxels]."""
    return np.asarray(1 << (DEPTH - depths.astype(np.int64)), np.int64)


def shared_depths(begins: Keys) -> NDArray[np.int64]:
    """Return for each leaf the depth of its lowest common ancestor with the leaf before it; 0 for the first leaf."""
    differ = np.bitwise_or.reduce(begins[1:] ^ begins[:-1], axis=1)
    shared = DEPTH - np.frexp(differ.astype(np.float64))[1].astype(np.int64)
    return np.concatenate((np.zeros(min(1, len(begins)), np.int64), shared))


_SPREAD = (
    (32, 0x1F00000000FFFF),
    (16, 0x1F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)
"""Shifts and masks that move the bits of a number apart, to each third place."""

_LAST = 0x1FFFFF


def morton_codes(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the Morton codes of keys: their bits interleaved as …zyxzyx. Their order is depth-first order."""
    codes = np.zeros(len(keys), np.int64)
    for axis in range(3):
        spread = keys[:, axis].astype(np.int64)
        for shift, mask in _SPREAD:
            spread = (spread | spread << shift) & mask
        codes |= spread << axis
    return codes


def _keys_of(codes: NDArray[np.int64]) -> Keys:
    """Return the keys of Morton codes, the inverse of ``morton_codes``."""
    keys = np.empty((len(codes), 3), np.uint16)
    shifts, masks = zip(*reversed(_SPREAD), strict=True)
    for axis in range(3):
        together = codes >> axis & masks[0]
        for shift, mask in zip(shifts, (*masks[1:], _LAST), strict=True):
            together = (together | together >> shift) & mask
        keys[:, axis] = together
    return keys


def _corners(low: ArrayLike, high: ArrayLike) -> NDArray[np.float64]:
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


def _window(between: NDArray[np.float64], low: ArrayLike, high: ArrayLike) -> tuple[list[int], list[int]]:
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
