"""Master lease: the time for which a machine of another host acts for its cloud without an answer from the master.

The master gives up a machine that misses ``MISSED`` heartbeats, and starts its containers elsewhere. A machine that was
frozen or disconnected must not resume as if nothing had happened: it stores no checkpoint until the master has answered
a recent heartbeat, since its checkpoint might be older than one that was made elsewhere meanwhile.
"""

from collections import deque

from engine.processes.heartbeats import BEAT_PERIOD, MISSED, Heartbeats
from ppaas.clock import Clock, monotonic

LEASE = (MISSED - 1) * BEAT_PERIOD
"""Length of the lease, from the sending of an answered heartbeat [s]; the master waits one beat period longer."""


class MasterLease:
    """Lease of one connection to the master, which answers heartbeats in order.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s], which advances while this process is stopped.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._asked: deque[float] = deque()
        self._since = clock()
        self._answers = 1
        self._heartbeats = Heartbeats(clock)

    def beat(self) -> bool:
        """Record that a heartbeat is sent; return whether the master still answers."""
        self._asked.append(self._clock())
        return not self._heartbeats.check({"master": self._answers})

    def answered(self) -> None:
        """Record the master's answer to the oldest unanswered heartbeat."""
        self._answers += 1
        if self._asked:
            self._since = self._asked.popleft()

    def holds(self) -> bool:
        """Return whether the lease is valid: the master cannot have given up this machine yet."""
        return self._clock() - self._since < LEASE
