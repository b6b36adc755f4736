"""Clearing of a box of a volume, as octomap_server's ``clear_bbx`` does it."""

import math

import numpy as np
from numpy.typing import ArrayLike

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.blocks import VoxelBlocks
from ppaas.mapping.volume.kernels.blocks import EDGE, VOXELS
from ppaas.mapping.volume.kernels.ends import MIDDLE
from ppaas.mapping.volume.parameters import VolumeParameters

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
    """Return the slots of the blocks that may reach into the box."""
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
