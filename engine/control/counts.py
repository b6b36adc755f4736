"""Counts of the master since its process started, for metrics."""

from bisect import bisect_left
from collections import Counter
from collections.abc import Sequence

from engine.control.views import GoalState

PLACEMENT_SECONDS = 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0, 60.0
"""Upper limits of the classes of placement times [s]: a warm start takes a tenth of a second, a cold one minutes."""

REQUEST_SECONDS = 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0
"""Upper limits of the classes of times until a request of REST is answered [s]: most paths take milliseconds."""


class BucketCounts:
    """Number of values in each of some classes, and the sum of all values.

    Parameters
    ----------
    limits : sequence of float
        Upper limits of the classes, rising; a last class without a limit is added.

    Attributes
    ----------
    counts : list of int
        Number of values in each class.
    total : float
        Sum of all values.
    """

    def __init__(self, limits: Sequence[float]) -> None:
        self.limits = tuple(limits)
        self.counts = [0] * (len(self.limits) + 1)
        self.total = 0.0

    def add(self, value: float) -> None:
        """Count a value."""
        self.counts[bisect_left(self.limits, value)] += 1
        self.total += value


class ControlCounts:
    """Counts of the master.

    Attributes
    ----------
    placements : BucketCounts
        Times from the order to start a container until it answered [s].
    containers_lost, machines_lost : int
        Numbers of containers that were replaced, and of machines that left, without being ended by the master.
    goals : Counter of GoalState
        Goals of REST and of tasks that have ended, by result.
    """

    def __init__(self) -> None:
        self.placements = BucketCounts(PLACEMENT_SECONDS)
        self.containers_lost = self.machines_lost = 0
        self.goals: Counter[GoalState] = Counter()
