"""Counts of the master since its process started, for metrics."""

from bisect import bisect_left
from collections import Counter
from collections.abc import Mapping, Sequence

from engine.control.views import STATES, GoalState
from engine.specs.work_counts import CLASSES, ENDED, FAILED, PLAN_MICROS, REUSED, STITCHED

PLACEMENT_SECONDS = 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0, 60.0
"""Upper limits of the classes of placement times [s]: a warm start takes a tenth of a second, a cold one minutes."""

LIFT_SECONDS = 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 180.0, 300.0, 600.0
"""Upper limits of the classes of waits for lifts [s]."""

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
    lift_waits : BucketCounts
        Times that robots have waited for lifts [s].
    containers_lost, machines_lost : int
        Numbers of containers that were replaced, and of machines that left, without being ended by the master.
    goals : Counter of GoalState
        Goals that have ended, by result.
    """

    def __init__(self) -> None:
        self.placements = BucketCounts(PLACEMENT_SECONDS)
        self.lift_waits = BucketCounts(LIFT_SECONDS)
        self.containers_lost = self.machines_lost = 0
        self.goals: Counter[GoalState] = Counter()
        self._work: Counter[str] = Counter()
        self._reported: dict[str, Counter[str]] = {}

    def machine_worked(self, machine: str, work: Mapping[str, int]) -> None:
        """Add what the containers of a machine have done since its last report; the first one is where it begins."""
        now = Counter(work)
        more = now - self._reported.get(machine, now)
        self._reported[machine] = now
        self._work += more
        for status, name in ENDED.items():
            self.goals[STATES[status]] += more[name]

    def machine_left(self, machine: str) -> None:
        """Forget what a machine has reported: its next agent begins at zero."""
        self._reported.pop(machine, None)

    def plans(self) -> tuple[list[int], float]:
        """Return the numbers of computed plans by class of planning time, and the sum of these times [s]."""
        return [self._work[name] for name in CLASSES], self._work[PLAN_MICROS] / 1e6

    def plan_origins(self) -> dict[str, int]:
        """Return the numbers of requests for plans by how they ended."""
        computed = sum(self._work[name] for name in CLASSES)
        return {
            "computed": computed,
            "reused": self._work[REUSED],
            "stitched": self._work[STITCHED],
            "failed": self._work[FAILED],
        }
