"""Master lease: the time for which a machine acts for its cloud without an answer from the master.

The master gives up a machine that misses ``MISSED`` heartbeats, and starts its containers elsewhere; and another master
may replace one that is frozen or cannot renew its own lease. A machine that was frozen or disconnected, or whose master
was, must not go on as if nothing had happened: it stores no checkpoint until a master that leads has answered a recent
heartbeat, since its checkpoint might be older than one that was made elsewhere meanwhile.
"""

from collections import deque

from engine.processes.heartbeats import BEAT_PERIOD, MISSED, Heartbeats
from ppaas.clock import Clock, uptime

LEASE = (MISSED - 1) * BEAT_PERIOD
"""Length of the lease, from the sending of an answered heartbeat [s]; the master waits one beat period longer."""

SILENT = 3
"""Number of heartbeats without an answer, with the one that is being sent, from which the master counts as silent."""

DENIED = 15
"""Number of answers in a row of a master that does not lead, after which no other one leads either. A standby takes the
lease after 3 s, and a machine finds it within another second: the store is unreachable for all of them."""


class MasterLease:
    """Lease of one connection to the master, which answers heartbeats in order.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s], which advances while this process is stopped.
    """

    def __init__(self, clock: Clock = uptime) -> None:
        self._clock = clock
        self._asked: deque[float] = deque()
        self._since = clock()
        self._answers = 1
        self._denials = 0
        self._heartbeats = Heartbeats(clock)

    def beat(self) -> bool:
        """Record that a heartbeat is sent; return whether the master still answers."""
        self._asked.append(self._clock())
        return not self._heartbeats.check({"master": self._answers})

    def answered(self, *, leads: bool = True) -> None:
        """Record the master's answer to the oldest unanswered heartbeat; without ``leads`` it extends no lease."""
        self._answers += 1
        asked = self._asked.popleft() if self._asked else self._since
        self._denials = 0 if leads else self._denials + 1
        if leads:
            self._since = asked

    @property
    def unanswered(self) -> int:
        """Number of heartbeats that the master has not answered yet."""
        return len(self._asked)

    def is_silent(self) -> bool:
        """Return whether the master has not answered the latest heartbeats."""
        return self.unanswered >= SILENT

    def nobody_leads(self) -> bool:
        """Return whether the master answers, and has not led for so long that another one would have been found."""
        return self._denials >= DENIED and not self.is_silent()

    def holds(self) -> bool:
        """Return whether the lease is valid: the master cannot have given up this machine yet."""
        return self._clock() - self._since < LEASE
