"""Run times: how long each node works, for the monitor that decides where it should run."""

from collections.abc import Callable

from ppaas.clock import Clock


class RunTimes:
    """How long nodes work at what they are told, each without what others do meanwhile.

    Parameters
    ----------
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self._of_others = 0.0
        self._sums: dict[str, tuple[int, float]] = {}

    def run(self, node: str, work: Callable[[], None]) -> None:
        """Let a node do something, and note how long it took; what it has others do is theirs."""
        before, self._of_others = self._of_others, 0.0
        began = self.clock()
        try:
            work()
        finally:
            whole = self.clock() - began
            self.add(node, whole - self._of_others)
            self._of_others = before + whole

    def add(self, node: str, seconds: float) -> None:
        """Note a time that was taken elsewhere."""
        count, total = self._sums.get(node, (0, 0.0))
        self._sums[node] = count + 1, total + seconds

    def take(self) -> dict[str, tuple[int, float]]:
        """Return how often each node worked since the last call of this, and for how long in all [s]."""
        sums, self._sums = self._sums, {}
        return sums
