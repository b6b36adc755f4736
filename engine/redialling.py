"""How long, and how often, an agent dials a master that went away, while containers wait."""

import asyncio
import itertools
import logging
from collections.abc import Awaitable, Callable

from engine import control
from engine.framing import FrameStream
from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

ADOPT_WITHIN = 30.0
"""Seconds for which containers outlive their master, where nothing else is said."""

RETRIES = (0.1, 0.2, 0.4, 0.8)
"""Seconds before the first, second … try; the last stays."""

Master = FrameStream[control.ToAgent]
Dial = Callable[[], Awaitable[Master]]


class Redial:
    """Dials until somebody answers or the time is over, which counts from when this is made.

    Parameters
    ----------
    within : float
        Seconds.
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, within: float, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._deadline = clock() + within
        self._delays = itertools.chain(RETRIES, itertools.repeat(RETRIES[-1]))

    async def __call__(self, dial: Dial) -> Master | None:
        """Return a new connection, or None where the time is over."""
        for delay in self._delays:
            if self._clock() + delay >= self._deadline:
                return None
            await asyncio.sleep(delay)
            try:
                async with asyncio.timeout(max(0.0, self._deadline - self._clock())):  # a way that is cut is silent
                    return await dial()
            except (Unavailable, TimeoutError) as error:
                logger.debug("no master yet: %s", error)
        return None
