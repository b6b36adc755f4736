"""Voxel volume: a 3D occupancy map built from point clouds by ray casting.

The rules are the same as for OctoMap's ``insertPointCloud`` (Hornung et al., "OctoMap: An Efficient Probabilistic 3D
Mapping Framework Based on Octrees", Autonomous Robots, 2013): each voxel is updated once per cloud; it is occupied if a
ray ends in it, else free if a ray passes it; log-odds are float32 and clamped. The voxels are stored in dense blocks of
8 × 8 × 8 instead of an octree, so an update descends no tree.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.errors import InvalidInput, QuotaExceeded
from ppaas.kernel_threads import limit_threads
from ppaas.mapping.volume.blocks import VoxelBlocks, codes_of
from ppaas.mapping.volume.kernels import blocks as kernels
from ppaas.mapping.volume.kernels import ends as end_kernels
from ppaas.mapping.volume.kernels import rays as ray_kernels
from ppaas.mapping.volume.kernels.blocks import EDGE
from ppaas.mapping.volume.kernels.ends import MIDDLE
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.thread_budget import Threads, one_thread

# -- bits of one scan, within the box around its rays ------------------------------------------------------------------

MOST_VOXELS = 1 << 29
"""Largest box around the rays of a scan [voxels]: 40 m wide and high at 0.05 m. It takes two bits per thread."""

_WORD = 64

Box = NDArray[np.int64]
"""(6,): keys of the least voxel x, y, z, and the size along x, y, z [voxels]."""


class ScanBits:
    """Buffers of the bits of a scan, reused from scan to scan; they hold zeros between two scans.

    Parameters
    ----------
    resolution : float
        Edge of a voxel [m].
    max_range : float
        Range at which rays are cut [m]; negative for none.
    """

    def __init__(self, resolution: float, max_range: float) -> None:
        self._resolution = resolution
        self._max_range = max_range
        self._buffer = np.zeros((2, 0), np.int64)

    def mark(
        self,
        ends: NDArray[np.float32],
        origin: NDArray[np.float32],
        parts: int,
        ground: NDArray[np.bool_] | None = None,
    ) -> tuple[Box, NDArray[np.int64], NDArray[np.int64]]:
        """Cast the rays of a scan; return their box and the words of passed and of occupied voxels, (parts, words).

        The caller sets these words to 0, or calls `discard`.

        Parameters
        ----------
        ends : (n, 3) float32 array
            In: points x, y, z in the map frame [m]. Out: ends of the rays.
        origin : (3,) float32 array
            Position of the sensor in the map frame [m].
        parts : int
            Number of threads.
        ground : (n,) bool array, optional
            Rays that end at no obstacle.

        Raises
        ------
        QuotaExceeded
            The rays lie in a box of too many voxels.
        """
        kinds, bounds = np.empty(len(ends), np.uint8), np.empty((parts, 2, 3), np.int64)
        find_ends = end_kernels.find_ends_parallel if parts > 1 else end_kernels.find_ends_serial
        find_ends(ends, origin, 1.0 / self._resolution, self._max_range, kinds, bounds)
        if ground is not None:
            kinds[ground & (kinds != end_kernels.NONE)] = end_kernels.PASSED
        box = _box(bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0))
        free, occupied = self._words(box, parts)
        mark_rays = ray_kernels.mark_rays_parallel if parts > 1 else ray_kernels.mark_rays_serial
        mark_rays(free, occupied, box, origin, self._resolution, ends, kinds)
        return box, free, occupied

    def discard(self) -> None:
        """Drop the buffers, after a scan that was not added to the map."""
        self._buffer = np.zeros((2, 0), np.int64)

    def _words(self, box: Box, parts: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        count = int(box[3:].prod())
        if count > MOST_VOXELS:
            raise QuotaExceeded(
                f"the rays of the point cloud lie in a box of {box[3]}×{box[4]}×{box[5]} voxels, and at most "
                f"{MOST_VOXELS} are allowed: choose a smaller sensor_model.max_range or a coarser resolution"
            )
        words = count // _WORD
        if self._buffer.shape[1] < parts * words:
            self._buffer = np.zeros((2, parts * words), np.int64)
        free, occupied = self._buffer[:, : parts * words].reshape(2, parts, words)
        return free, occupied


def _box(low: NDArray[np.int64], high: NDArray[np.int64]) -> Box:
    """Return the smallest box of whole blocks, rows of whole words, and a margin of a voxel around all keys."""
    first = (low - 1) // EDGE * EDGE
    size = -((first - high - 2) // EDGE) * EDGE
    size[0] = -(-size[0] // _WORD) * _WORD
    return np.concatenate((first, size))


# -- the volume --------------------------------------------------------------------------------------------------------

PARALLEL_FROM = 2_000
"""Least number of points that are worth several threads."""


class VoxelVolume:
    """3D occupancy map that grows with each point cloud.

    Parameters
    ----------
    parameters : VolumeParameters
        Resolution, sensor model, and limits.
    threads : callable
        Returns the number of threads of an insertion.

    Attributes
    ----------
    parameters : VolumeParameters
        As given.
    blocks : VoxelBlocks
        Log-odds of all known voxels.
    """

    def __init__(self, parameters: VolumeParameters, threads: Threads = one_thread) -> None:
        self.parameters = parameters
        self.blocks = VoxelBlocks(parameters.max_blocks)
        self._model = parameters.model()
        self._threads = threads
        self._bits = ScanBits(parameters.resolution, parameters.max_range)

    def insert(
        self,
        points: NDArray[np.float32],
        origin: ArrayLike,
        *,
        ground: NDArray[np.bool_] | None = None,
        also: VoxelBlocks | None = None,
    ) -> None:
        """Add a point cloud.

        Parameters
        ----------
        points : (n, 3) float32 array
            Points x, y, z in the map frame [m]. Points that are not finite, beyond the range of keys, or outside
            ``point_cloud_min_z`` and ``point_cloud_max_z`` are ignored.
        origin : (3,) array
            Position of the sensor in the map frame [m].
        ground : (n,) bool array, optional
            Whether each point is of the ground: its ray makes voxels free, and none occupied.
        also : VoxelBlocks, optional
            Blocks to which the same rays are added.

        Raises
        ------
        InvalidInput
            The arrays have other shapes, or the map does not reach the sensor.
        QuotaExceeded
            The map or the box around the rays would be too large; the map is unchanged.
        """
        sensor = self._checked(points, origin)
        own = self.parameters
        within = (points[:, 2] >= own.point_cloud_min_z) & (points[:, 2] <= own.point_cloud_max_z)
        ends = points[within]  # a copy: the rays are cut in place
        if not len(ends):
            return
        below = ground[within] if ground is not None else None
        with limit_threads(self._threads() if len(ends) >= PARALLEL_FROM else 1) as parts:
            box, free, occupied = self._bits.mark(ends, sensor, parts, below)
            self._update(box, free, occupied, also, parallel=parts > 1)

    def clear(self) -> None:
        """Forget all voxels, as the service ``reset`` does."""
        self.blocks = VoxelBlocks(self.parameters.max_blocks)

    def _checked(self, points: NDArray[np.float32], origin: ArrayLike) -> NDArray[np.float32]:
        """Return the position of the sensor; raise an error if the cloud or the position is invalid."""
        sensor = np.array(origin, np.float32)
        if points.ndim != 2 or points.shape[1] != 3 or points.dtype != np.float32 or sensor.shape != (3,):
            raise InvalidInput(
                f"a point cloud must be float32 of shape (n, 3) with an origin of 3 numbers, not {points.dtype} of "
                f"shape {points.shape} with an origin of shape {sensor.shape}"
            )
        reach = (MIDDLE - 1) * self.parameters.resolution
        if not (np.abs(sensor) <= reach).all():
            raise InvalidInput(f"the sensor must be within {reach:g} m of the origin of the map, not at {sensor}")
        return sensor

    def _update(
        self,
        box: Box,
        free: NDArray[np.int64],
        occupied: NDArray[np.int64],
        also: VoxelBlocks | None,
        *,
        parallel: bool,
    ) -> None:
        """Add the bits of a scan to the blocks, and clear them."""
        touched = np.zeros(tuple(box[:2:-1] // kernels.EDGE), np.uint8)
        collect = kernels.collect_parallel if parallel else kernels.collect_serial
        collect(free, occupied, box, touched)
        indices = np.flatnonzero(touched)
        where = np.stack(np.unravel_index(indices, touched.shape)[::-1], axis=1) + box[:3] // kernels.EDGE
        codes = codes_of(where)
        try:
            targets = [(blocks, blocks.add(codes)) for blocks in (also, self.blocks) if blocks is not None]
        except QuotaExceeded:
            self._bits.discard()
            raise
        update = kernels.update_parallel if parallel else kernels.update_serial
        for number, (blocks, slots) in enumerate(targets, 1):
            words = (free[0], occupied[0]) if number == len(targets) else (free[0].copy(), occupied[0].copy())
            update(words[0].view(np.uint8), words[1].view(np.uint8), box, indices, slots, blocks.log_odds, self._model)
