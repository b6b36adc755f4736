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
from ppaas.mapping.volume.kernels.ends import MIDDLE
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.scan_bits import Box, ScanBits
from ppaas.thread_budget import Threads, one_thread

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
