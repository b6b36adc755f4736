"""How long, and how often, an agent dials a master that went away, while containers wait."""

import asyncio
import logging
from collections.abc import Awaitable, Callable

from engine.protocols import control_link
from engine.protocols.framing import FrameStream
from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

ADOPT_WITHIN = 30.0
"""Seconds for which containers outlive their master, where nothing else is said."""

PERIOD = 0.1
"""Seconds between two tries, which cost next to nothing: all robots of the machine wait for that which is answered."""

Master = FrameStream[control_link.ToAgent]
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

    async def __call__(self, dial: Dial) -> Master | None:
        """Return a new connection, or None where the time is over."""
        while self._clock() + PERIOD < self._deadline:
            await asyncio.sleep(PERIOD)
            try:
                async with asyncio.timeout(max(0.0, self._deadline - self._clock())):  # a way that is cut is silent
                    return await dial()
            except (Unavailable, TimeoutError) as error:
                logger.debug("no master yet: %s", error)
        return None
