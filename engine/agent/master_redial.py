"""Master redial: dials the master again after a lost connection, for a limited time; and where the masters are."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Protocol

from engine.protocols import control_link
from engine.protocols.framing import FrameStream
from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

ADOPT_WITHIN = 30.0
"""Default time for which containers outlive their master [s]."""

PERIOD = 0.1
"""Time between two attempts [s]; short, since an attempt is cheap and all robots of the machine wait."""

Master = FrameStream[control_link.ToAgent]
Dial = Callable[[], Awaitable[Master]]


class MasterRedial:
    """Dialler that retries until the master answers or the time limit, counted from construction, has passed.

    Parameters
    ----------
    within : float
        Time limit [s].
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, within: float, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._deadline = clock() + within

    async def __call__(self, dial: Dial) -> Master | None:
        """Return a new connection, or None after the time limit."""
        while self._clock() + PERIOD < self._deadline:
            await asyncio.sleep(PERIOD)
            try:
                async with asyncio.timeout(max(0.0, self._deadline - self._clock())):  # a cut network answers nothing
                    return await dial()
            except (Unavailable, TimeoutError) as error:
                logger.debug("the master is not reachable yet: %s", error)
        return None


class MasterDirectory(Protocol):
    """Addresses of the masters of a machine's cloud."""

    @property
    def current(self) -> str:
        """Address of the master that this machine follows."""
        ...

    def note(self, masters: tuple[str, ...]) -> tuple[str, ...]:
        """Take the addresses of all masters; return the Zenoh endpoints of their routers."""
        ...

    async def another_leads(self) -> bool:
        """Return whether a master at another address leads; that is then the current one."""
        ...


class OneMaster:
    """The directory of a machine whose masters all have one address, as on the cloud's own host.

    Parameters
    ----------
    current : str
        The address.
    """

    def __init__(self, current: str) -> None:
        self.current = current

    def note(self, masters: tuple[str, ...]) -> tuple[str, ...]:
        """Do nothing: the router connects to no other."""
        return ()

    async def another_leads(self) -> bool:
        """Return false."""
        return False
