"""Floors of a drive, by the height of the robot: it stays on one, and rises or sinks quickly to the next.

Heights by the pressure of the air drift with the weather. What counts is therefore how far a robot has risen between
two stays; a floor that it comes back to corrects the drift.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput

Numbers = NDArray[np.float64]

STEP, WINDOW = 0.5, 2.0
"""Time between two heights that are looked at [s], and half of the time over which each is a mean [s]."""

RISE, WITHIN = 0.5, 2.5
"""Difference of the heights this time before and after from which a robot rises or sinks [m, s]."""

SHORTEST = 5.0
"""Shortest stay [s]."""

END = 4.0
"""Time at the ends of a stay whose mean is the height there [s]."""

SAME = 1.4
"""Difference of heights up to which two stays are on one floor [m]."""


@dataclass(frozen=True, slots=True)
class DriveLevel:
    """Floor of a drive.

    Parameters
    ----------
    elevation : float
        Height above the lowest floor [m].
    spans : list of (float, float)
        First and last time of each stay [s], in order.
    """

    elevation: float
    spans: list[tuple[float, float]] = field(default_factory=list)

    def covers(self, stamps: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which times are within its stays."""
        inside = np.zeros(len(stamps), np.bool_)
        for first, last in self.spans:
            inside |= (stamps >= first) & (stamps <= last)
        return inside


def levels_of(stamps: NDArray[np.float64], heights: NDArray[np.float64]) -> list[DriveLevel]:
    """Return the floors of a drive, lowest first.

    Parameters
    ----------
    stamps, heights : (n,) array
        Times [s] and heights [m], in any order.

    Raises
    ------
    InvalidInput
        A height is not finite, or the robot stays nowhere.
    """
    if len(stamps) == 0 or not (np.isfinite(stamps).all() and np.isfinite(heights).all()):
        raise InvalidInput("heights of a drive must be finite numbers, at least one")
    order = np.argsort(stamps, kind="stable")
    times, means = _means(stamps[order], heights[order])
    stays = [stay for stay in _stays(times, means) if stay[1] - stay[0] >= SHORTEST]
    if not stays:
        raise InvalidInput(f"the robot stays on no floor for {SHORTEST:g} s")
    found = _joined(stays, times, means)
    found[0].spans[0] = -np.inf, found[0].spans[0][1]
    latest = max(found, key=lambda level: level.spans[-1])
    latest.spans[-1] = latest.spans[-1][0], np.inf
    lowest = min(level.elevation for level in found)
    leveled = [DriveLevel(round(level.elevation - lowest, 2), level.spans) for level in found]
    return sorted(leveled, key=lambda level: level.elevation)


def _means(
    stamps: NDArray[np.float64], heights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return times in equal steps, and the mean height around each."""
    times = np.arange(stamps[0], stamps[-1] + STEP, STEP)
    sums = np.concatenate(((0.0,), np.cumsum(heights - heights[0])))
    first, last = np.searchsorted(stamps, times - WINDOW), np.searchsorted(stamps, times + WINDOW, "right")
    counts = last - first
    between = np.interp(times, stamps, heights)
    means = np.where(counts > 0, heights[0] + (sums[last] - sums[first]) / np.maximum(counts, 1), between)
    return times, means


def _stays(times: Numbers, means: Numbers) -> Iterator[tuple[float, float]]:
    """Yield the first and last time of each time in which the robot does not rise or sink."""
    before, after = np.interp(times - WITHIN, times, means), np.interp(times + WITHIN, times, means)
    steady = np.concatenate(((False,), np.abs(after - before) < RISE, (False,)))
    edges = np.flatnonzero(steady[1:] != steady[:-1])
    for first, last in zip(edges[::2], edges[1::2] - 1, strict=True):
        yield float(times[first]), float(times[last])


def _joined(stays: list[tuple[float, float]], times: Numbers, means: Numbers) -> list[DriveLevel]:
    """Return the floors of stays, in the order in which they are reached first."""

    def height(first: float, last: float) -> float:
        return float(means[(times >= first) & (times <= last)].mean())

    found = [DriveLevel(0.0, [stays[0]])]
    here = found[0]
    for (begin, end), (first, last) in itertools.pairwise(stays):
        rise = height(first, min(first + END, last)) - height(max(end - END, begin), end)
        elevation = here.elevation + rise
        nearest = min(found, key=lambda level: abs(level.elevation - elevation))
        if nearest is here and abs(rise) <= SAME:
            here.spans[-1] = here.spans[-1][0], last  # it has not left the floor
            continue
        if abs(nearest.elevation - elevation) > SAME:
            nearest = DriveLevel(elevation)
            found.append(nearest)
        here = nearest
        here.spans.append((first, last))
    return found
