"""Detection of connected machines and containers that stopped responding; they are replaced as if they had died."""

import asyncio
from collections.abc import Callable, Mapping

from engine.processes.heartbeats import BEAT_PERIOD, Heartbeats

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
