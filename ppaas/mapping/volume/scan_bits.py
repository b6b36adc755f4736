"""Bits of one scan: the voxels that its rays pass and end in, within the box around them."""

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import QuotaExceeded
from ppaas.mapping.volume.kernels import ends as end_kernels
from ppaas.mapping.volume.kernels import rays as ray_kernels
from ppaas.mapping.volume.kernels.blocks import EDGE

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
