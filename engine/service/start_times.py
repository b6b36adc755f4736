"""When containers were ordered, and how long they took until they answered."""

from ppaas.clock import Clock, monotonic


class StartTimes:
    """Of the containers that are there, or awaited.

    Parameters
    ----------
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._ordered: dict[str, float] = {}
        self._awaited: dict[str, float] = {}
        self._took: dict[str, float] = {}

    def __len__(self) -> int:
        """Return of how many containers something is known."""
        return len(self._ordered)

    def order(self, container: str) -> None:
        """Note that a container is to be started."""
        self._ordered[container] = self._awaited[container] = self._clock()

    def send(self, container: str) -> None:
        """Note that its machine is told of it only now."""
        self._awaited[container] = self._clock()

    def is_awaited(self, container: str) -> bool:
        """Tell whether it is to be started, and has not answered yet."""
        return container in self._awaited

    def answer(self, container: str) -> None:
        """Note that it answers."""
        began = self._awaited.pop(container, None)
        if began is not None:
            self._took[container] = self._clock() - began

    def age(self, container: str) -> float:
        """Return how long ago it was ordered [s]; 0 where that is not known."""
        now = self._clock()
        return now - self._ordered.get(container, now)

    def took(self, container: str) -> float | None:
        """Return how long it took from the order to its machine until it answered [s]; None where it has not."""
        return self._took.get(container)

    def forget(self, container: str) -> None:
        """Forget a container that is no more."""
        for times in (self._ordered, self._awaited, self._took):
            times.pop(container, None)
