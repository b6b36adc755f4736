"""Session with the master: a machine dials it, reports its start, and acts for its cloud while its lease holds.

The master gives up a machine that misses ``MISSED`` heartbeats, and starts its containers elsewhere; and another master
may replace one that is frozen or cannot renew its own lease. A machine that was frozen or disconnected, or whose master
was, must not go on as if nothing had happened: it stores no checkpoint until a master that leads has answered a recent
heartbeat, since its checkpoint might be older than one that was made elsewhere meanwhile.
"""

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any, Protocol

import msgspec

from engine.agent.config import AgentConfig
from engine.agent.kernel_service import progress_of
from engine.processes.heartbeats import BEAT_PERIOD, MISSED, Heartbeats
from engine.protocols import control_link
from engine.protocols.framing import FrameStream
from engine.runtimes.compilation.kernel_compiler import KernelCompiler
from ppaas.clock import Clock, monotonic, uptime
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

Master = FrameStream[control_link.ToAgent]

Dial = Callable[[], Awaitable[Master]]


# -- dialling ----------------------------------------------------------------------------------------------------------


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


REDIAL_PERIOD = 0.1
"""Time between two attempts [s]; short, since an attempt is cheap and all robots of the machine wait."""


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
        while self._clock() + REDIAL_PERIOD < self._deadline:
            await asyncio.sleep(REDIAL_PERIOD)
            try:
                async with asyncio.timeout(max(0.0, self._deadline - self._clock())):  # a cut network answers nothing
                    return await dial()
            except (Unavailable, TimeoutError) as error:
                logger.debug("the master is not reachable yet: %s", error)
        return None


# -- reports before registration ---------------------------------------------------------------------------------------

USUAL_START = 1.0
"""Time within which a machine has usually started, if its kernels are compiled [s]; it reports nothing until then."""

REPORT_PERIOD = 0.5
"""Period of the reports [s]."""


async def report_start(
    config: AgentConfig, compiler: KernelCompiler, dial: Callable[[], Awaitable[Master]], delay: float = USUAL_START
) -> None:
    """Report to the master that this machine is starting, and how far its kernels are, until cancelled.

    Parameters
    ----------
    config : AgentConfig
        Settings of the machine.
    compiler : KernelCompiler
        Its kernel compiler, which begins now: it waits for the one of the fork server, and knows how far that is.
    dial : callable
        Connects to the master.
    delay : float
        Time until the first report [s].
    """
    await asyncio.sleep(delay)
    compiler.begin()
    while True:
        try:
            stream = await dial()
        except Unavailable as error:
            logger.debug("the master cannot be told yet that the machine is starting: %s", error)
        else:
            await _report(config, compiler, stream)
        await asyncio.sleep(REPORT_PERIOD)


async def _report(config: AgentConfig, compiler: KernelCompiler, stream: Master) -> None:
    """Report until the master closes the connection."""
    closed = asyncio.create_task(stream.receive())
    try:
        while not closed.done():
            stream.write(control_link.MachineStarting(config.machine, config.secret, progress_of(compiler)))
            await asyncio.wait((closed,), timeout=REPORT_PERIOD)
    finally:
        closed.cancel()
        await asyncio.gather(closed, return_exceptions=True)
        await stream.close()


# -- lease -------------------------------------------------------------------------------------------------------------

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


# -- session -----------------------------------------------------------------------------------------------------------


class MasterSession:
    """Master session of one machine, over all its connections to masters.

    The machine acts for its cloud from the master's welcome until the connection ends, while its lease is valid. A
    machine that does not act stores no checkpoints and publishes nothing on the fabric, since its containers may have
    been replaced elsewhere.

    Parameters
    ----------
    remote : bool
        Whether the master is on another host, so that the network may be down.

    Attributes
    ----------
    lease : MasterLease
        Lease of the current connection.
    epoch : int
        Epoch of the latest master that this machine has followed.
    refused : bool
        Whether the master of the current connection was refused.
    """

    def __init__(self, *, remote: bool) -> None:
        self.remote = remote
        self._stream: FrameStream[Any] | None = None
        self._welcome = False
        self.lease = MasterLease()
        self.epoch = 0
        self.refused = False

    def begin(self, stream: FrameStream[Any]) -> None:
        """Begin a connection to a master that has not sent its welcome yet."""
        self._stream = stream
        self._welcome = self.refused = False
        self.lease = MasterLease()

    def welcome(self, epoch: int) -> bool:
        """Record the welcome of a master, for which the machine acts from now on; return whether it was accepted.

        A master of an earlier epoch than this machine has followed was replaced. It is notified, and refused.
        """
        if epoch < self.epoch:
            self.tell(control_link.Outranked(self.epoch))
            self.refused = True
            return False
        self.epoch, self._welcome = epoch, True
        return True

    def hang_up(self) -> None:
        """Abort the connection."""
        if self._stream is not None:
            self._stream.abort()

    def lost(self) -> None:
        """Record that the connection has ended."""
        self._stream, self._welcome = None, False

    def tell(self, news: msgspec.Struct) -> None:
        """Send a report to the master; dropped without one, as the next master gets the whole state on registration."""
        if self._stream is not None:
            self._stream.write(news)

    def acts(self) -> bool:
        """Return whether the machine acts for its cloud."""
        return self._welcome and self.lease.holds()

    def may_be_replaced(self) -> bool:
        """Return whether containers of this machine may have been replaced elsewhere.

        That is so while the machine does not act for its cloud, except while its master answers and nobody leads: a
        store that no master can use lets no other one take over, and this machine's containers are the only ones.
        """
        return not self.acts() and not (self._welcome and self.lease.nobody_leads())
