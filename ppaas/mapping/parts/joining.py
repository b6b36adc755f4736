"""Joining: the current part of a map becomes one with another part where both show the same places."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import MapsNotMerged
from ppaas.mapping.closures.submaps import travelled
from ppaas.mapping.graph.pose_graph import Edges
from ppaas.mapping.merging.merge import DEFAULTS, merge
from ppaas.mapping.parts.map_parts import MapParts, extract
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.planar_poses import PoseArray, compose, relative

LEAST_TRAVEL = DEFAULTS.least_travel
"""Way driven in a part before it is compared with others: a merge needs places over such a way [m]."""

GROWTH = 6.0
"""Way driven between two comparisons [m]; it grows with the part, so that their cost stays proportional to it."""

GROWTH_SHARE = 0.2
"""Growth of the part between two comparisons, as a share of its length."""


class JoinedParts(NamedTuple):
    """Two parts that are one now.

    Parameters
    ----------
    numbers : tuple of int
        Numbers of the two parts.
    edges : Edges
        Closures between them, of the key frames of the whole map.
    poses : (k, 3) float64 array
        Poses of all key frames; poses of parts that did not join have not moved, and neither has the first one of the
        older part.
    """

    numbers: tuple[int, int]
    edges: Edges
    poses: PoseArray


class _Cancelled(Exception):  # not an error
    """The comparison is no longer wanted."""


class JoiningSchedule:
    """When the current part is compared with the others again."""

    def __init__(self) -> None:
        self._part, self._next = -1, LEAST_TRAVEL

    def is_due(self, parts: MapParts, poses: PoseArray) -> bool:
        """Return whether the current part has grown enough; if so, it is not due again before it has grown further.

        Parameters
        ----------
        parts : MapParts
        poses : (k, 3) array
            Poses of all key frames.
        """
        if parts.is_whole:
            return False
        if parts.current != self._part:
            self._part, self._next = parts.current, LEAST_TRAVEL
        driven = sum(_length(poses[run]) for run in parts.runs(parts.current, len(poses)))
        if driven < self._next:
            return False
        self._next = driven + max(GROWTH, GROWTH_SHARE * driven)
        return True


def join(mapping: Mapping, parts: MapParts, cancelled: Callable[[], bool]) -> JoinedParts | None:
    """Join the current part with the first of the others that passes the gates of a merge; None if none does.

    Parameters
    ----------
    mapping : Mapping
        All key frames, and a graph whose nodes have their poses; left unchanged.
    parts : MapParts
    cancelled : callable
        Returns whether to give up.

    Raises
    ------
    InvalidGraph
        The joined graph cannot be solved.
    """
    count = len(mapping.frames)
    current = parts.indices(parts.current, count)
    for other in parts.others:
        found = _joined(mapping, parts.indices(other, count), current, cancelled)
        if found is not None:
            return JoinedParts((other, parts.current), *found)
        if cancelled():
            return None
    return None


def _joined(
    mapping: Mapping, other: NDArray[np.int64], current: NDArray[np.int64], cancelled: Callable[[], bool]
) -> tuple[Edges, PoseArray] | None:
    """Return closures between two parts, and the poses of all key frames; None if they do not merge."""

    def progress(_done: int, _all: int) -> None:
        if cancelled():
            raise _Cancelled

    # The older part is the one with the first key frame: its frame stays.
    older, later = (other, current) if other[0] < current[0] else (current, other)
    try:
        merged = merge(extract(mapping, older), extract(mapping, later), done=progress).mapping
    except (MapsNotMerged, _Cancelled):
        return None
    places, poses = np.concatenate((older, later)), mapping.graph.poses.copy()
    poses[places] = merged.graph.poses
    edges = merged.graph.edges
    between = (edges.first < len(older)) != (edges.second < len(older))
    new = edges.take(between)
    return new._replace(first=places[new.first], second=places[new.second]), poses


def placed_beside(mapping: Mapping, parts: MapParts, margin: float) -> PoseArray:
    """Return poses of all key frames at which the parts lie beside each other, in their order along x.

    Parameters
    ----------
    mapping : Mapping
    parts : MapParts
    margin : float
        Least distance between points of two parts [m].
    """
    count, poses = len(mapping.frames), mapping.graph.poses.copy()
    numbers = sorted({*parts.others, parts.current})
    end = _extent(mapping, parts.indices(numbers[0], count))[1]
    for number in numbers[1:]:
        chosen = parts.indices(number, count)
        low, high = _extent(mapping, chosen)
        shift = end + margin - low
        poses[chosen] = compose(np.array((shift, 0.0, 0.0)), poses[chosen])
        end = high + shift
    return poses


def _extent(mapping: Mapping, chosen: NDArray[np.int64]) -> tuple[float, float]:
    """Return the least and the largest x of the points of key frames [m]."""
    frames, poses = mapping.frames, mapping.graph.poses
    lows, highs = [], []
    for index in chosen.tolist():
        points = frames.points[index][frames.valid[index]].astype(np.float64)
        x, _, theta = poses[index]
        seen = np.append(x, x + np.cos(theta) * points[:, 0] - np.sin(theta) * points[:, 1])
        lows.append(float(seen.min()))
        highs.append(float(seen.max()))
    return min(lows), max(highs)


def _length(poses: PoseArray) -> float:
    """Return the way along poses, turns included [m]."""
    return float(travelled(relative(poses[:-1], poses[1:])).sum())
