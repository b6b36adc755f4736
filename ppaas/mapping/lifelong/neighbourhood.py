"""Neighbourhoods: each key frame compared with those that show the same place."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.lifelong.passes import divided_passes, mileage
from ppaas.mapping.lifelong.scan_views import ScanViews, Views
from ppaas.mapping.near_poses import nearest_poses
from ppaas.planar_poses import PoseArray

NEAR, MOST = 2.0, 40
"""Largest distance between two key frames that are compared, see `nearest_poses` [m], and their largest number."""

ROWS = 16
"""Number of key frames whose neighbourhoods are computed at once, which bounds the memory."""


class Neighbourhood(NamedTuple):
    """Key frames around one, oldest first.

    Parameters
    ----------
    frame : int
        The key frame.
    others : (m,) int64 array
        The key frames around it.
    views : Views
        What they saw at its points.
    passes : (m,) int64 array
        Number of the pass of each, ascending; ``own`` is the key frame's own pass.
    own : int
    """

    frame: int
    others: NDArray[np.int64]
    views: Views
    passes: NDArray[np.int64]
    own: int

    @property
    def newer(self) -> NDArray[np.int64]:
        """Numbers of later passes, latest first."""
        found: NDArray[np.int64] = np.unique(self.passes[self.passes > self.own])[::-1]
        return found


class Neighbourhoods:
    """Neighbourhoods of key frames.

    Parameters
    ----------
    frames : KeyFrames
    poses : (k, 3) array
        Their poses.
    apart : float
        Least distance travelled between two passes [m].
    """

    def __init__(self, frames: KeyFrames, poses: PoseArray, apart: float) -> None:
        self._poses, self._apart = poses, apart
        self._views, self._mileage = ScanViews(frames, poses), mileage(poses)

    def around(self, chosen: NDArray[np.int64]) -> Iterator[Neighbourhood]:
        """Yield the neighbourhoods of some key frames."""
        near = nearest_poses(self._poses[chosen], self._poses, MOST + 1, NEAR)
        for begin in range(0, len(chosen), ROWS):
            frames = chosen[begin : begin + ROWS]
            others = [_others(frame, found) for frame, found in zip(frames, near[begin : begin + ROWS], strict=True)]
            ends = np.cumsum([len(found) for found in others])
            views = self._views.compare(np.repeat(frames, np.diff(ends, prepend=0)), np.concatenate(others))
            parts = zip(*(np.split(array, ends[:-1]) for array in views), strict=True)
            for frame, found, part in zip(frames.tolist(), others, parts, strict=True):
                yield self._neighbourhood(frame, found, Views(*part))

    def _neighbourhood(self, frame: int, others: NDArray[np.int64], views: Views) -> Neighbourhood:
        at = int(np.searchsorted(others, frame))
        passes = divided_passes(self._mileage[np.insert(others, at, frame)], self._apart)
        return Neighbourhood(frame, others, views, np.delete(passes, at), int(passes[at]))


def _others(frame: int, near: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the key frames beside one, ascending, of the nearest poses."""
    found: NDArray[np.int64] = np.sort(near[(near >= 0) & (near != frame)])
    return found
