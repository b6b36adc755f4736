"""Run times of nodes, for the node monitor that decides where each should run."""

from collections.abc import Callable

from ppaas.clock import Clock


class RunTimes:
    """Run times of callbacks by node, excluding the callbacks of other nodes that they trigger.

    Parameters
    ----------
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self._of_others = 0.0
        self._sums: dict[str, tuple[int, float]] = {}

    def run(self, node: str, work: Callable[[], None]) -> None:
        """Run a callback of a node and record its time; callbacks of other nodes within it are recorded for them."""
        before, self._of_others = self._of_others, 0.0
        began = self.clock()
        try:
            work()
        finally:
            whole = self.clock() - began
            self.add(node, whole - self._of_others)
            self._of_others = before + whole

    def add(self, node: str, seconds: float) -> None:
        """Record the time of a job."""
        count, total = self._sums.get(node, (0, 0.0))
        self._sums[node] = count + 1, total + seconds

    def take(self) -> dict[str, tuple[int, float]]:
        """Return the number and total time of each node's callbacks and jobs since the last call [s]."""
        sums, self._sums = self._sums, {}
        return sums
