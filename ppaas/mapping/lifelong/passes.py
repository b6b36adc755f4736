"""Passes: the times that the robot came by a place, after it was elsewhere, and what it saw of each cell in them."""

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.submaps import travelled
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.map_drawing import bounds, count_beams
from ppaas.maps.grid import GridInfo
from ppaas.planar_poses import PoseArray, relative


def mileage(poses: PoseArray) -> NDArray[np.float64]:
    """Return the distance (k,) travelled at each key frame, turns included [m].

    Where key frames between have been removed, it is less than the robot drove: passes then count as one.
    """
    steps = relative(poses[:-1], poses[1:])
    return np.concatenate(([0.0], np.cumsum(travelled(steps))))


def divided_passes(mileages: NDArray[np.float64], apart: float) -> NDArray[np.int64]:
    """Return the number (n,) of the pass of each key frame near a place, 0 for the first.

    Parameters
    ----------
    mileages : (n,) array
        Of key frames near a place, ascending [m].
    apart : float
        Least distance travelled between two passes [m].
    """
    return np.concatenate(([0], np.cumsum(np.diff(mileages) >= apart))).astype(np.int64)


# -- what the robot saw of each cell -----------------------------------------------------------------------------------

STAYING = 1.5
"""Factor of the distance after which points in a cell count as another pass: people stand for some time."""

PART = 3.0
"""Distance travelled between two parts of a drive that are drawn one after the other [m]."""


class CellPasses:
    """Numbers of passes, as grids.

    Parameters
    ----------
    info : GridInfo
        Geometry of the grids; all beams that are added lie in it.
    apart : float
        Least distance travelled between two passes [m].

    Attributes
    ----------
    ended, passed : (h, w) uint8 array
        Numbers of passes in which a beam ended in each cell, and in which one passed and none ended there. A cell that
        is seen all the time counts again after that distance.
    """

    def __init__(self, info: GridInfo, apart: float) -> None:
        self.ended, self.passed = np.zeros(info.shape, np.uint8), np.zeros(info.shape, np.uint8)
        self._info, self._apart = info, apart
        self._last_ended, self._last_passed = (np.full(info.shape, -np.inf, np.float32) for _ in range(2))

    def add(self, frames: KeyFrames, chosen: NDArray[np.int64], mileage: NDArray[np.float64]) -> None:
        """Add key frames.

        Parameters
        ----------
        frames : KeyFrames
        chosen : (n,) int64 array
            Their indices, ascending.
        mileage : (k,) array
            Distance travelled at each of all key frames [m].
        """
        parts = np.floor(mileage[chosen] / PART)
        for part in np.split(chosen, np.flatnonzero(np.diff(parts)) + 1):
            if len(part):
                self._add(frames, part, float(mileage[part[0]]))

    def _add(self, frames: KeyFrames, part: NDArray[np.int64], at: float) -> None:
        poses, points, valid = frames.poses[part], frames.points[part], frames.valid[part]
        info, (x0, y0, x1, y1) = self._info, bounds(poses, points, valid)
        (left, right), (bottom, top) = (
            [int((value - corner) / info.resolution) for value in ends]
            for ends, corner in (((x0, x1), info.origin.x), ((y0, y1), info.origin.y))
        )
        window = slice(bottom, top + 1), slice(left, right + 1)
        ended, passed = (np.zeros(self.ended[window].shape, np.uint16) for _ in range(2))
        corner = Pose2D(info.origin.x + left * info.resolution, info.origin.y + bottom * info.resolution, 0.0)
        height, width = self.ended[window].shape
        part_info = GridInfo(info.resolution, width, height, corner)
        count_beams((ended, passed), part_info, poses, points, valid)
        _count(self.ended[window], self._last_ended[window], ended > 0, at, STAYING * self._apart)
        _count(self.passed[window], self._last_passed[window], (passed > 0) & (ended == 0), at, self._apart)


def _count(
    counts: NDArray[np.uint8], last: NDArray[np.float32], seen: NDArray[np.bool_], at: float, apart: float
) -> None:
    """Count a pass in the cells that were seen, unless one was counted a short way before."""
    again = seen & (at - last >= apart) & (counts < np.iinfo(np.uint8).max)
    counts[again] += 1
    last[again] = at
