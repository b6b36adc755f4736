"""Blocks of voxels that grow with the map, in a hash table, and their clearing in a box."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.errors import InvalidInput, QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.kernels import blocks as kernels
from ppaas.mapping.volume.kernels.blocks import EDGE, VOXELS
from ppaas.mapping.volume.kernels.ends import MIDDLE
from ppaas.mapping.volume.parameters import VolumeParameters

Words = NDArray[np.int64]

_FIRST = 64
"""Number of blocks that memory is allocated for at first."""

PAGE = 64
"""Number of blocks of a page, the unit in which changes are noted."""


class VoxelBlocks:
    """Blocks of 8 × 8 × 8 log-odds, and the table that finds them.

    Parameters
    ----------
    most : int
        Largest number of blocks.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._used = 0
        self._changed: set[int] = set()
        self._log_odds = np.full((_FIRST, kernels.VOXELS), np.nan, np.float32)
        self._codes, self._slots = _table(2 * _FIRST)

    def __len__(self) -> int:
        return self._used

    @property
    def log_odds(self) -> NDArray[np.float32]:
        """Log-odds of all voxels, (blocks, 512): voxel (x, y, z) of a block at 64 · z + 8 · y + x; NaN if unknown."""
        return self._log_odds[: self._used]

    @property
    def codes(self) -> Words:
        """Codes of the blocks in the order of their slots, (blocks,)."""
        codes = np.empty(self._used, np.int64)
        full = self._codes != kernels.EMPTY
        codes[self._slots[full]] = self._codes[full]
        return codes

    @property
    def table(self) -> tuple[Words, Words]:
        """Codes and slots of the hash table, see `ppaas.mapping.volume.kernels.blocks`."""
        return self._codes, self._slots

    @property
    def corners(self) -> Words:
        """Least keys of the blocks in the order of their slots, (blocks, 3) x, y, z."""
        mask = (1 << kernels.BITS) - 1
        shifts = np.arange(3) * kernels.BITS
        return np.asarray((self.codes[:, None] >> shifts & mask) * kernels.EDGE)

    @property
    def pages(self) -> int:
        """Number of pages."""
        return -(-self._used // PAGE)

    def take_changed(self) -> set[int]:
        """Return the pages with blocks that were passed to `add` or `note_change` since the last call."""
        changed, self._changed = self._changed, set()
        return changed

    def note_change(self, slots: Words) -> None:
        """Note that the blocks in these slots (n,) change."""
        self._changed.update(np.unique(slots // PAGE).tolist())

    def add(self, codes: Words) -> Words:
        """Return the slots of blocks, (n,), to change them; blocks that do not exist yet are added.

        Parameters
        ----------
        codes : (n,) int64 array
            Codes of different blocks.

        Raises
        ------
        QuotaExceeded
            There would be too many blocks; none is added.
        """
        found = self.find(codes)
        needed = self._used + int((found < 0).sum())
        if needed > self._most:
            raise QuotaExceeded(
                f"the map would have {needed} blocks of 8 × 8 × 8 voxels, and max_blocks allows {self._most}: choose a "
                "coarser resolution or a smaller sensor_model.max_range"
            )
        if needed > self._used:
            self._reserve(needed)
            kernels.find_slots(self._codes, self._slots, codes, found, self._used)
            self._used = needed
        self.note_change(found)
        return found

    def find(self, codes: Words) -> Words:
        """Return the slots of blocks, (n,); −1 for those that do not exist."""
        found = np.empty(len(codes), np.int64)
        kernels.look_up(self._codes, self._slots, codes, found)
        return found

    def trim(self) -> None:
        """Free the memory that is reserved for more blocks."""
        self._log_odds = self.log_odds.copy()

    def _reserve(self, needed: int) -> None:
        if needed > len(self._log_odds):
            rows = min(max(needed, len(self._log_odds) * 3 // 2), self._most)
            grown = np.empty((rows, kernels.VOXELS), np.float32)
            grown[: self._used] = self.log_odds
            grown[self._used :] = np.nan
            self._log_odds = grown
        if 2 * needed > len(self._codes):
            codes = self.codes
            self._codes, self._slots = _table(4 * needed)
            kernels.find_slots(self._codes, self._slots, codes, np.empty(len(codes), np.int64), 0)


def codes_of(blocks: Words) -> Words:
    """Return the codes of blocks, (n,), from their indices (n, 3) along x, y, z: least keys divided by 8."""
    return np.asarray((blocks << np.arange(3) * kernels.BITS).sum(axis=1))


def _table(entries: int) -> tuple[Words, Words]:
    size = 1 << (entries - 1).bit_length()
    return np.full(size, kernels.EMPTY, np.int64), np.zeros(size, np.int64)


# -- clearing of a box, as octomap_server's ``clear_bbx`` --------------------------------------------------------------

_VOXELS = np.arange(VOXELS)
_CENTRES = np.stack([_VOXELS % EDGE, _VOXELS // EDGE % EDGE, _VOXELS // EDGE**2], axis=1) + 0.5
"""Centres of the voxels of a block [voxels]."""

_DIAGONAL = EDGE * math.sqrt(2.0)
"""Diagonal of a block in the plane [voxels]."""

_AT_ONCE = 4096
"""Number of blocks whose voxels are examined at once."""

_NO_MOTION = Pose2D(0.0, 0.0, 0.0)


def clear_box(
    blocks: VoxelBlocks, low: ArrayLike, high: ArrayLike, parameters: VolumeParameters, motion: Pose2D = _NO_MOTION
) -> None:
    """Make all known voxels of blocks free whose centres are in a box.

    Parameters
    ----------
    blocks : VoxelBlocks
        Modified.
    low, high : (3,) array
        Opposite corners of the box in the map frame [m].
    parameters : VolumeParameters
    motion : Pose2D
        Motion of the blocks in the map frame since they were inserted.

    Raises
    ------
    InvalidInput
        A corner is not finite.
    """
    corners = np.array([low, high], np.float64)
    if corners.shape != (2, 3) or not np.isfinite(corners).all():
        raise InvalidInput("the corners of the box to clear must be finite: x, y and z in metres")
    least, most = np.sort(corners, axis=0)
    begins, free = blocks.corners - MIDDLE, parameters.model().least
    near = _near(begins, least, most, parameters.resolution, motion)
    for part in np.array_split(near, max(1, len(near) // _AT_ONCE)):
        places = _in_map((begins[part, None] + _CENTRES) * parameters.resolution, motion)
        inside = ((places >= least) & (places <= most)).all(axis=2)
        values = blocks.log_odds[part]
        values[inside & ~np.isnan(values)] = free
        blocks.log_odds[part] = values
        blocks.note_change(part)


def _near(begins: np.ndarray, least: np.ndarray, most: np.ndarray, resolution: float, motion: Pose2D) -> np.ndarray:
    centres = _in_map((begins + 0.5 * EDGE) * resolution, motion)
    margin = 0.5 * _DIAGONAL * resolution
    return np.flatnonzero(((centres >= least - margin) & (centres <= most + margin)).all(axis=1))


def _in_map(places: np.ndarray, motion: Pose2D) -> np.ndarray:
    """Return places (…, 3) after a motion in the plane."""
    c, s = math.cos(motion.theta), math.sin(motion.theta)
    moved = places.copy()
    moved[..., 0] = c * places[..., 0] - s * places[..., 1] + motion.x
    moved[..., 1] = s * places[..., 0] + c * places[..., 1] + motion.y
    return moved
