"""Who still lives: beats are counted, and whoever misses several of them is frozen, though its connection stands."""

from collections.abc import Mapping

from ppaas.clock import Clock, monotonic

BEAT_PERIOD = 1.0
"""Seconds between two beats, and, where nothing else is said, between two looks at who has beaten."""

MISSED = 4
"""Periods in a row in which looks find no new beat; then its process is taken for frozen. A busy machine delays a beat
by tenths of a second: with 16 containers driving on two cores at a load of eight, commands were half a second apart at
most. What holds an event loop longest is a large map: a copy of one of 4000 by 4000 cells takes a client's container
0.3 s."""


class Heartbeats:
    """Compares counts of beats from look to look.

    Missed beats are counted, not seconds: if our own process stood still, as with a computer that slept, it had no
    look at anybody meanwhile, and the first look after it counts nothing.

    Parameters
    ----------
    clock : callable
        Monotonic seconds.
    looks : int
        In each period. With more of them who is frozen is known sooner after the last period that is forgiven, and no
        earlier.
    """

    def __init__(self, clock: Clock = monotonic, looks: int = 1) -> None:
        self._clock = clock
        self._most = MISSED * looks
        self._looked = clock()
        self._known: dict[str, tuple[int, int]] = {}

    def look(self, beats: Mapping[str, int]) -> list[str]:
        """Take the counts of all who should beat; return who is frozen.

        Parameters
        ----------
        beats : mapping of str to int
            How often each that should beat has done so; it is watched from the first look that it is here, since it may
            freeze before its first beat.
        """
        now = self._clock()
        stood_still = now - self._looked > 2.0 * BEAT_PERIOD
        self._looked = now
        before, self._known = self._known, {}
        for name, count in beats.items():
            counted, missed = before.get(name, (None, 0))
            missed = 0 if count != counted or stood_still else missed + 1
            self._known[name] = (count, missed)
        return [name for name, (_, missed) in self._known.items() if missed >= self._most]
