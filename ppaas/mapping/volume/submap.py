"""Submap: blocks of voxels hung on a key frame, which move with it."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.volume.blocks import VoxelBlocks, codes_of
from ppaas.mapping.volume.kernels.blocks import EDGE, VOXELS
from ppaas.mapping.volume.kernels.ends import MIDDLE
from ppaas.mapping.volume.kernels.motion import sample_moved
from ppaas.mapping.volume.parameters import SensorLogOdds

LEAST_MOTION = 0.25
"""Motion of a submap below which its voxels stay where they are [voxels]."""

NO_STEP = Pose2D(0.0, 0.0, 0.0)

_MOST_INDEX = 2 * MIDDLE // EDGE
_NEIGHBOURS = np.stack(np.meshgrid(np.arange(3), np.arange(3), indexing="ij"), axis=-1).reshape(-1, 2)
"""Offsets of the blocks that a turned block may touch, from the first of them: its diagonal is 11.3 voxels."""


class VolumeSubmap:
    """Part of a volume that moves as a whole.

    The blocks are stored as they were inserted, so that several corrections do not blur them.

    Parameters
    ----------
    number : int
        Number that no other submap of the map has or had.
    stamp : float
        Time of the key frame that the submap hangs on [s].
    most : int
        Largest number of blocks.

    Attributes
    ----------
    number : int
    stamp : float
    blocks : VoxelBlocks
        Log-odds that the clouds of this submap added, at their first places.
    motion : Pose2D
        Motion of the submap in the map frame since then.
    """

    def __init__(self, number: int, stamp: float, most: int) -> None:
        self.number, self.stamp, self.motion = number, stamp, Pose2D(0.0, 0.0, 0.0)
        self.blocks = VoxelBlocks(most)

    @classmethod
    def of(cls, number: int, stamp: float, motion: Pose2D, blocks: VoxelBlocks) -> "VolumeSubmap":
        """Return a submap with blocks, at their first places."""
        submap = cls(number, stamp, 0)
        submap.motion, submap.blocks = motion, blocks
        return submap

    def placed(self, resolution: float, step: Pose2D = NO_STEP) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """Return the codes (n,) and the log-odds (n, 512) of the blocks at their current place, moved by a step."""
        motion = step @ self.motion
        if self.reach_of_motion(motion, resolution) < LEAST_MOTION * resolution:
            return self.blocks.codes, self.blocks.log_odds
        return moved(self.blocks, motion, resolution)

    def reach_of_motion(self, motion: Pose2D, resolution: float) -> float:
        """Return the largest distance that a motion in the map frame moves a voxel of this submap [m]."""
        if not len(self.blocks):
            return 0.0
        corners = (self.blocks.corners[:, :2] - MIDDLE) * resolution
        x, y = np.concatenate((corners, corners + EDGE * resolution)).T
        c, s = math.cos(motion.theta), math.sin(motion.theta)
        return float(np.hypot(c * x - s * y + motion.x - x, s * x + c * y + motion.y - y).max())

    def join(self, other: "VolumeSubmap", model: SensorLogOdds, resolution: float) -> None:
        """Take over the voxels of another submap; both move together from now on."""
        relative = self.motion.inverse() @ other.motion
        if other.reach_of_motion(relative, resolution) < LEAST_MOTION * resolution:
            add_log_odds(self.blocks, other.blocks.codes, other.blocks.log_odds, model)
        else:
            add_log_odds(self.blocks, *moved(other.blocks, relative, resolution), model)


def moved(blocks: VoxelBlocks, motion: Pose2D, resolution: float) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the codes (n,) and the log-odds (n, 512) of blocks after a motion in the map frame.

    Blocks that leave the range of keys are lost.
    """
    wanted = _touched(blocks, motion, resolution)
    sampled = np.full((len(wanted), VOXELS), np.nan, np.float32)
    back = motion.inverse()
    inverse = (math.cos(back.theta), math.sin(back.theta), back.x / resolution, back.y / resolution)
    sample_moved(*blocks.table, blocks.log_odds, wanted, inverse, sampled)
    known = ~np.isnan(sampled).all(axis=1)
    return wanted[known], sampled[known]


def add_log_odds(
    blocks: VoxelBlocks, codes: NDArray[np.int64], log_odds: NDArray[np.float32], model: SensorLogOdds
) -> None:
    """Add log-odds (n, 512), NaN where unknown, to the blocks of these codes (n,), within the limits of the model.

    Raises
    ------
    QuotaExceeded
        There would be too many blocks; none is changed.
    """
    slots = blocks.add(codes)
    old = blocks.log_odds[slots]
    new = np.clip(np.where(np.isnan(old), np.float32(0.0), old) + log_odds, model.least, model.most)
    blocks.log_odds[slots] = np.where(np.isnan(log_odds), old, new)


def _touched(blocks: VoxelBlocks, motion: Pose2D, resolution: float) -> NDArray[np.int64]:
    """Return the codes of the blocks that have voxels of moved blocks, and perhaps of some others."""
    corners = blocks.corners
    x0, y0 = (corners[:, :2] - MIDDLE).T
    square = np.array([[0.0, 0.0], [EDGE, 0.0], [0.0, EDGE], [EDGE, EDGE]])
    x, y = x0[:, None] + square[:, 0], y0[:, None] + square[:, 1]
    c, s = math.cos(motion.theta), math.sin(motion.theta)
    places = np.stack((c * x - s * y + motion.x / resolution, s * x + c * y + motion.y / resolution), axis=-1)
    indices = np.floor((places + MIDDLE) / EDGE).astype(np.int64)
    first, last = indices.min(axis=1), indices.max(axis=1)
    every = first[:, None] + _NEIGHBOURS
    inside = (every <= last[:, None]).all(axis=2) & (every >= 0).all(axis=2) & (every < _MOST_INDEX).all(axis=2)
    layers = np.broadcast_to(corners[:, None, 2:] // EDGE, (*inside.shape, 1))
    return np.unique(codes_of(np.concatenate((every, layers), axis=2)[inside]))
