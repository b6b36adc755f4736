"""Start times of containers: time of the order, and time until the container answered."""

from ppaas.clock import Clock, monotonic


class StartTimes:
    """Start times of running and awaited containers.

    Parameters
    ----------
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._ordered: dict[str, float] = {}
        self._awaited: dict[str, float] = {}
        self._patient: dict[str, float] = {}
        self._took: dict[str, float] = {}

    def __len__(self) -> int:
        """Return the number of known containers."""
        return len(self._ordered)

    def order(self, container: str) -> None:
        """Record the order to start a container."""
        self._ordered[container] = self._awaited[container] = self._clock()

    def send(self, container: str) -> None:
        """Record that the order was sent to the machine; the time until the answer counts from now."""
        self._awaited[container] = self._clock()

    def postpone(self, container: str) -> None:
        """Record that a container, which has not answered yet, still waits for kernels: be patient from now on."""
        self._patient[container] = self._clock()

    def patience(self, container: str, timeout: float) -> float:
        """Return the time for which an answer may still be awaited [s], if that is ``timeout`` without `postpone`."""
        since = self._patient.get(container)
        return 0.0 if since is None else timeout - (self._clock() - since)

    def is_awaited(self, container: str) -> bool:
        """Return whether a container was ordered and has not answered yet."""
        return container in self._awaited

    def answer(self, container: str) -> float | None:
        """Record the first answer of a container; return the time that it took [s], None for a later answer."""
        began = self._awaited.pop(container, None)
        if began is None:
            return None
        took = self._took[container] = self._clock() - began
        return took

    def age(self, container: str) -> float:
        """Return the time since the order [s]; 0 if the container is unknown."""
        now = self._clock()
        return now - self._ordered.get(container, now)

    def took(self, container: str) -> float | None:
        """Return the time from the order to the machine until the answer [s]; None before the answer."""
        return self._took.get(container)

    def forget(self, container: str) -> None:
        """Forget a container that has ended."""
        for times in (self._ordered, self._awaited, self._patient, self._took):
            times.pop(container, None)
