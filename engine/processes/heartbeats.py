"""Heartbeats: a process that misses several in a row is frozen, even if its connection is still open.

A master counts the heartbeats of the connected machines and containers, and replaces what stopped responding as if it
had died. A process without a connection to its keeper shows its heartbeats in a file.
"""

import asyncio
import os
from collections.abc import Callable, Mapping
from pathlib import Path

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


LOOKS = 4
"""Checks per heartbeat period. A frozen process is given up 4 to 4.25 s after its last heartbeat. With two checks, it
took up to 4.5 s, and on a busy computer not every robot was served again within 5 s."""

Beats = Callable[[], Mapping[str, int]]
"""Returns the number of heartbeats of each watched process, by name."""

GiveUp = Callable[[str], None]
"""Called with the name of a process that missed its heartbeats."""


async def watch(*watched: tuple[Beats, GiveUp], meanwhile: Callable[[], None] = lambda: None) -> None:
    """Check heartbeats forever, and give up each process that misses too many.

    Parameters
    ----------
    watched : tuple of callables
        Heartbeat counts, and the action for a process that missed its heartbeats.
    meanwhile : callable
        Called at each check.
    """
    kinds = [(Heartbeats(checks=LOOKS), beats, give_up) for beats, give_up in watched]
    while True:
        await asyncio.sleep(BEAT_PERIOD / LOOKS)
        meanwhile()
        for heartbeats, beats, give_up in kinds:
            for name in heartbeats.check(beats()):
                give_up(name)


class BeatFile:
    """File whose time of modification is the last heartbeat of a process.

    Parameters
    ----------
    folder : Path
        Folder of the file.
    name : str
        Name of the process.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self._path = folder / f"{name}.beat"

    def beat(self) -> None:
        """Record a heartbeat; raises ``OSError`` if the folder is gone."""
        try:
            os.utime(self._path)  # takes no space, so it works on a full disk
        except FileNotFoundError:
            self._path.touch(mode=0o600)

    def last(self) -> int | None:
        """Return a number that changes with each heartbeat; None before the first."""
        try:
            return self._path.stat().st_mtime_ns
        except FileNotFoundError:
            return None

    def clear(self) -> None:
        """Forget the heartbeats of an earlier process."""
        self._path.unlink(missing_ok=True)
