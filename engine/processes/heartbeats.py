"""Heartbeats: a process that misses several in a row is frozen, even if its connection is still open."""

from collections.abc import Mapping

from ppaas.clock import Clock, monotonic

BEAT_PERIOD = 1.0
"""Time between two heartbeats, and by default between two checks [s]."""

MISSED = 4
"""Number of periods in a row without a heartbeat after which a process counts as frozen.

A busy machine delays a heartbeat by tenths of a second: with 16 containers driving on two cores at a load of eight,
commands were at most half a second apart. The longest block of an event loop is a large map: a copy of one of
4000 by 4000 cells takes a client's container 0.3 s."""


class Heartbeats:
    """Finds frozen processes by comparing heartbeat counts between checks.

    It counts missed heartbeats, not seconds: if this process itself was stopped, as on a suspended computer, there were
    no checks meanwhile, and the first check afterwards counts no miss.

    Parameters
    ----------
    clock : callable
        Monotonic time [s].
    checks : int
        Number of checks in each period. More checks find a frozen process sooner after the last tolerated period, but
        never before.
    """

    def __init__(self, clock: Clock = monotonic, checks: int = 1) -> None:
        self._clock = clock
        self._most = MISSED * checks
        self._last_check = clock()
        self._known: dict[str, tuple[int, int]] = {}

    def check(self, beats: Mapping[str, int]) -> list[str]:
        """Check all processes; return the names of the frozen ones.

        Parameters
        ----------
        beats : mapping of str to int
            Number of heartbeats so far, by name of process. A process is watched from the first check with its name,
            since it may freeze before its first heartbeat.
        """
        now = self._clock()
        was_stopped = now - self._last_check > 2.0 * BEAT_PERIOD
        self._last_check = now
        before, self._known = self._known, {}
        for name, count in beats.items():
            counted, missed = before.get(name, (None, 0))
            missed = 0 if count != counted or was_stopped else missed + 1
            self._known[name] = (count, missed)
        return [name for name, (_, missed) in self._known.items() if missed >= self._most]
