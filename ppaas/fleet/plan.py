"""Plan of a fleet: the cell of each robot at each step."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class FleetPlan:
    """Conflict-free paths of all robots, in steps of the same duration.

    Parameters
    ----------
    steps : (t, n) int32 array
        Cell of each robot at each time; the first row are the starts, the last one the goals.
    bound : int
        Sum of the lengths of shortest paths, below which no cost is.
    """

    steps: NDArray[np.int32]
    bound: int

    @property
    def arrivals(self) -> NDArray[np.int64]:
        """Time of the last arrival of each robot at its goal, (n,) int64."""
        away = self.steps != self.steps[-1]
        last = len(self.steps) - np.argmax(away[::-1], axis=0)
        return np.where(away.any(axis=0), last, 0)

    @property
    def cost(self) -> int:
        """Sum of the arrivals."""
        return int(self.arrivals.sum())

    @property
    def makespan(self) -> int:
        """Time of the last arrival of all."""
        return int(self.arrivals.max(initial=0))
