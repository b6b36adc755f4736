"""Submaps: chunks of successive key frames, which are searched and matched as a whole."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

TURN_LENGTH = 0.5
"""Distance that a turn of 1 rad counts as [m/rad]."""


class Submap(NamedTuple):
    """Successive key frames.

    Parameters
    ----------
    first, end : int
        Index of the first key frame, and of the one after the last.
    """

    first: int
    end: int

    @property
    def middle(self) -> int:
        """Index of the key frame in the middle."""
        return (self.first + self.end) // 2


def travelled(measurements: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the lengths (n,) of steps (n, 3), turns included [m]."""
    turned = np.abs((measurements[:, 2] + math.pi) % (2.0 * math.pi) - math.pi)
    lengths: NDArray[np.float64] = np.hypot(measurements[:, 0], measurements[:, 1]) + TURN_LENGTH * turned
    return lengths


class Submaps:
    """Growing list of finished submaps; the key frames after the last one belong to the submap that still grows.

    Parameters
    ----------
    travel : float
        Length after which a submap is finished [m].
    """

    def __init__(self, travel: float = 3.0) -> None:
        self.finished: list[Submap] = []
        self._travel = travel
        self._first = self._count = 0
        self._length = 0.0

    def add(self, step: NDArray[np.float64]) -> Submap | None:
        """Append a key frame, and return the submap that it finishes: the one before it.

        Parameters
        ----------
        step : (3,) array
            Pose of the key frame in the frame of the one before; the first key frame's is ignored.
        """
        self._length += float(travelled(step[None])[0]) if self._count else 0.0
        if self._count and self._length >= self._travel:
            return self._finish()
        self._count += 1
        return None

    def finish(self) -> Submap | None:
        """Finish the submap that still grows, at the end of a run; None if it has no key frame."""
        if self._count == self._first:
            return None
        finished = Submap(self._first, self._count)
        self.finished.append(finished)
        self._first, self._length = self._count, 0.0
        return finished

    def _finish(self) -> Submap:
        finished = Submap(self._first, self._count)
        self.finished.append(finished)
        self._first, self._length = self._count, 0.0
        self._count += 1
        return finished
