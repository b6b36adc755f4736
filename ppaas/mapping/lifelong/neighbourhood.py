"""Neighbourhoods: each key frame compared with those that show the same place, by views of its points."""

from collections.abc import Iterator
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.lifelong.passes import divided_passes, mileage
from ppaas.mapping.near_poses import nearest_poses
from ppaas.planar_poses import PoseArray, relative

# -- views: what a laser saw at the points of another scan -------------------------------------------------------------

AGREEING, THROUGH = 0.1, 0.2
"""Difference of ranges up to which two scans agree, and from which a laser looked through a place [m]."""

BESIDE = 0.03
"""Angle to each side of a point within which all beams have to end behind it [rad]."""

FARTHEST = 12.0
"""Range up to which points are compared [m]: beyond it, small errors of the heading matter."""


class PointSighting(IntEnum):
    """Observation of the place of a point by another scan."""

    HIDDEN = 0
    """Nothing: the place is hidden, out of sight or at an edge."""
    CONFIRMED = 1
    """A point at the same place."""
    EMPTY = 2
    """All beams around it end behind it."""


class Views(NamedTuple):
    """Comparison of m pairs of key frames.

    Parameters
    ----------
    seen : (m, b) uint8 array
        `PointSighting` of the other laser at each point of the first scan of a pair.
    blocked : (m, b) bool array
        Whether the other laser saw a point where the beam of the first one passed.
    """

    seen: NDArray[np.uint8]
    blocked: NDArray[np.bool_]


class ScanViews:
    """Comparison of key frames.

    Parameters
    ----------
    frames : KeyFrames
    poses : (k, 3) array
        Their poses.
    """

    def __init__(self, frames: KeyFrames, poses: PoseArray) -> None:
        self._frames, self._poses = frames, poses
        ranges = np.hypot(frames.points[..., 0], frames.points[..., 1])
        ranges[~frames.valid] = np.nan
        self._side = max(1, round(BESIDE / abs(frames.geometry.angle_increment)))
        self._ranges, self._nearest = ranges, _nearest_beside(ranges, self._side)

    def compare(self, first: NDArray[np.int64], other: NDArray[np.int64]) -> Views:
        """Return the comparison of pairs (m,) of key frames."""
        seen, _ = self._seen(first, other)
        back, beams = self._seen(other, first)
        blocked = np.zeros(seen.shape, np.bool_)
        rows, points = np.nonzero(back == PointSighting.EMPTY)
        blocked[rows, beams[rows, points]] = True
        return Views(seen, blocked)

    def _seen(self, first: NDArray[np.int64], other: NDArray[np.int64]) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
        """Return the view (m, b) of the other laser at each point of the first, and the beam (m, b) towards it."""
        frames, geometry = self._frames, self._frames.geometry
        x, y, theta = relative(self._poses[other], self._poses[first]).astype(np.float32).T[..., np.newaxis]
        px, py = frames.points[first, :, 0], frames.points[first, :, 1]
        at_x, at_y = x + np.cos(theta) * px - np.sin(theta) * py, y + np.sin(theta) * px + np.cos(theta) * py
        turn = (np.arctan2(at_y, at_x) - geometry.angle_min) % (2.0 * np.pi)
        if geometry.angle_increment < 0.0:
            turn -= 2.0 * np.pi
        beams = np.rint(turn / geometry.angle_increment).astype(np.int64)
        inside = frames.valid[first] & (beams >= 1) & (beams < geometry.beams - 1)
        beams = np.where(inside, beams, min(1, geometry.beams - 1))
        distance, rows = np.hypot(at_x, at_y), other[:, np.newaxis]
        inside &= (distance < FARTHEST) & (self._ranges[first] < FARTHEST)
        with np.errstate(invalid="ignore"):
            empty = inside & (distance < self._nearest[rows, beams] - THROUGH)
            off = [
                np.abs(distance - self._ranges[rows, np.where(inside, beams + side, 0)]) <= AGREEING
                for side in (-1, 0, 1)
            ]
        confirmed = inside & (off[0] | off[1] | off[2])
        seen = np.where(
            empty, np.uint8(PointSighting.EMPTY), np.where(confirmed, np.uint8(PointSighting.CONFIRMED), np.uint8(0))
        )
        return seen, beams


def _nearest_beside(ranges: NDArray[np.float32], side: int) -> NDArray[np.float32]:
    """Return the nearest end (k, b) of each beam and those beside it; NaN unless all have a reading."""
    nearest, beams = np.full_like(ranges, np.nan), ranges.shape[1]
    if beams > 2 * side:
        inner = nearest[:, side : beams - side]
        inner[:] = ranges[:, : beams - 2 * side]
        for begin in range(1, 2 * side + 1):
            np.minimum(inner, ranges[:, begin : beams - 2 * side + begin], out=inner)
    return nearest


# -- neighbourhoods ----------------------------------------------------------------------------------------------------

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
