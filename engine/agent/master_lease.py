"""How long a machine of another host acts for its cloud without hearing from it.

The master takes a machine for gone that misses ``MISSED`` beats, and has what it carried served elsewhere. A machine
that stood still, or was cut off, must not go on as if nothing had happened: until the master has answered a beat of the
last seconds it keeps no checkpoint, which might be older than one that was made elsewhere meanwhile.
"""

from collections import deque

from engine.processes.heartbeats import BEAT_PERIOD, MISSED, Heartbeats
from ppaas.clock import Clock, monotonic

LEASE = (MISSED - 1) * BEAT_PERIOD
"""Seconds from a beat that was answered. The master waits a period longer before it gives a machine up."""


class Lease:
    """Of one connection to the master, which answers each beat in turn.

    Parameters
    ----------
    clock : callable
        Monotonic seconds; they go on while this process is stopped.
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._asked: deque[float] = deque()
        self._since = clock()
        self._answers = 1
        self._heartbeats = Heartbeats(clock)

    def beat(self) -> bool:
        """Note that a beat is sent; return whether the master still answers."""
        self._asked.append(self._clock())
        return not self._heartbeats.check({"master": self._answers})

    def answered(self) -> None:
        """Note that the master has answered the oldest beat that it had not."""
        self._answers += 1
        if self._asked:
            self._since = self._asked.popleft()

    def holds(self) -> bool:
        """Tell whether the master cannot have given this machine up yet."""
        return self._clock() - self._since < LEASE
