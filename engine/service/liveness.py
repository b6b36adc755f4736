"""Who is connected and shows no sign of life is ended, so that it is replaced as if it had died."""

import asyncio
from collections.abc import Callable, Mapping

from engine.processes.heartbeats import BEAT_PERIOD, Heartbeats

LOOKS = 4
"""Looks in each period of beats: what is frozen is given up 4 to 4.25 s after its last beat. With two looks it was 4.5,
and on a busy computer not every robot was served again within five."""

Beats = Callable[[], Mapping[str, int]]
"""Counts how often each that should beat has done so."""

GiveUp = Callable[[str], None]


async def watch(*watched: tuple[Beats, GiveUp], meanwhile: Callable[[], None] = lambda: None) -> None:
    """Look at all who beat, for ever, and give those up that are frozen.

    Parameters
    ----------
    watched : tuple of callables
        Who beats, and what to do with whoever does not any more.
    meanwhile : callable
        Called with each look.
    """
    kinds = [(Heartbeats(checks=LOOKS), beats, give_up) for beats, give_up in watched]
    while True:
        await asyncio.sleep(BEAT_PERIOD / LOOKS)
        meanwhile()
        for heartbeats, beats, give_up in kinds:
            for name in heartbeats.check(beats()):
                give_up(name)
