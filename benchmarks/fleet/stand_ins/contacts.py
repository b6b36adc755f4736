"""Contacts of discs that move: those on the straight ways between two times count, too."""

import numpy as np
from numpy.typing import NDArray

Places = NDArray[np.float64]

FAR = 9.0
"""Gap before there are two discs [m]."""


class Contacts:
    """Counts the times that two discs begin to touch.

    Attributes
    ----------
    count : int
    nearest : float
        Smallest gap between two discs so far [m]; negative if they touched.
    """

    def __init__(self) -> None:
        self.count, self.nearest = 0, FAR
        self._before: Places = np.empty((0, 2))
        self._touching = np.zeros((0, 0), np.bool_)

    def see(self, places: Places, radii: NDArray[np.float64]) -> None:
        """Take the places of all discs, (n, 2) [m], and their radii, (n,) [m]; new ones are the last."""
        known = len(self._before)
        before = np.concatenate([self._before, places[known:]])
        gaps = _gaps(before, places, radii)
        touching = np.zeros(gaps.shape, np.bool_)
        touching[: len(self._touching), : len(self._touching)] = self._touching
        self.count += int(((gaps <= 0.0) & ~touching).sum()) // 2
        self.nearest = min(self.nearest, float(gaps.min(initial=FAR)))
        self._before, self._touching = places, _gaps(places, places, radii) <= 0.0


def _gaps(before: Places, after: Places, radii: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the smallest gap of each pair of discs on straight ways from one time to another [m]."""
    apart = before[:, None] - before[None]
    change = after[:, None] - after[None] - apart
    squared = np.maximum((change**2).sum(axis=2), 1e-12)
    part = np.clip(-(apart * change).sum(axis=2) / squared, 0.0, 1.0)
    nearest = np.hypot(*(apart + part[..., None] * change).transpose(2, 0, 1))
    gaps: NDArray[np.float64] = nearest - radii[:, None] - radii[None]
    np.fill_diagonal(gaps, FAR)
    return gaps
