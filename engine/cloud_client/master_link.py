"""Link of an endpoint to its master, which reconnects when the master was lost, and registers again.

An access connects it, here to a master on the same host.
"""

import asyncio
import enum
import logging
import math
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar

from engine.calls.caller import Caller, Frame
from engine.control.master_calls.interface import EndpointCalls, MasterCalls, Registration
from engine.protocols.address import UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.sockets import Streams, dial
from ppaas.clock import Clock, monotonic
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

T = TypeVar("T")
P = ParamSpec("P")
R = TypeVar("R")


# -- access ------------------------------------------------------------------------------------------------------------


class SilenceCause(enum.Enum):
    """Reason why a master does not answer, as far as it is known."""

    UNKNOWN = enum.auto()
    """It is slow, stopped or not reachable."""
    MOVED = enum.auto()
    """Another one leads, which the next dial reaches."""
    REPLACED = enum.auto()
    """Another one leads, which this endpoint does not reach."""


class MasterAccess(Protocol):
    """Access to a master.

    Attributes
    ----------
    secret : str
        Secret of the cloud's own processes; empty if a certificate identifies this machine.
    is_far : bool
        Whether the master is on another host, so that the network may be down.
    """

    secret: str
    is_far: bool

    async def dial(self) -> Streams:
        """Connect to the master that leads.

        Raises
        ------
        Conflict
            The cloud was started with other settings than this endpoint has.
        Unavailable
            No master is reachable.
        """
        ...

    async def silence(self) -> SilenceCause:
        """Return the reason why the master does not answer."""
        ...


class OwnMaster:
    """Access to the master of this host.

    Parameters
    ----------
    address : UnixAddress
        Its socket for endpoints.
    secret : str
        Secret of the cloud's own processes.
    is_replaced : callable
        Returns whether another process leads.
    """

    is_far = False

    def __init__(self, address: UnixAddress, secret: str, is_replaced: Callable[[], Awaitable[bool]]) -> None:
        self.secret = secret
        self._address = address
        self._is_replaced = is_replaced

    async def dial(self) -> Streams:
        """Connect to the master."""
        return await dial(self._address)

    async def silence(self) -> SilenceCause:
        """Return whether another process leads: its endpoints are on its own host."""
        return SilenceCause.REPLACED if await self._is_replaced() else SilenceCause.UNKNOWN


# -- link --------------------------------------------------------------------------------------------------------------

RETRY = 0.2
"""Time between two attempts to reach the master [s]."""

PATIENCE = 15.0
"""Time for which a call waits for a master [s]."""


class MasterLink:
    """Calls the master, whichever process that is.

    Parameters
    ----------
    access : MasterAccess
        Access to the master.
    registration : callable
        Returns the argument of the first call on each connection.
    served : EndpointCalls
        Serves the calls of the master.
    found : callable
        Called after each registration, before other calls go on: reports to the master what this endpoint has.
    clock : callable
        Returns monotonic seconds.
    """

    def __init__(
        self,
        access: MasterAccess,
        registration: Callable[[], Registration],
        served: EndpointCalls,
        found: Callable[[], None],
        clock: Clock = monotonic,
    ) -> None:
        self._access = access
        self._registration = registration
        self._served = served
        self._found = found
        self._clock = clock
        self._answered = -math.inf
        self._caller: Caller | None = None
        self._up = asyncio.Event()

    @property
    def silence(self) -> float:
        """Time since the master answered [s]; infinite if it never has."""
        return self._clock() - self._answered

    @property
    def is_up(self) -> bool:
        """True while the master is connected."""
        return self._up.is_set()

    async def run(self) -> None:
        """Keep the link up until cancelled.

        Raises
        ------
        Conflict, NotPermitted
            The master refuses this endpoint, or the cloud was started with other settings.
        """
        while True:
            try:
                stream: FrameStream[Frame] = FrameStream(*await self._access.dial(), Frame)
            except Unavailable as error:
                logger.debug("the master is not reachable yet: %s", error)
            else:
                await self._serve(stream)
            await asyncio.sleep(RETRY)

    async def _serve(self, stream: FrameStream[Frame]) -> None:
        caller = self._caller = Caller(stream, {EndpointCalls: self._served})
        serving = asyncio.create_task(caller.serve())
        try:
            await caller.call(MasterCalls.register, self._registration())
            self._answered = self._clock()
            self._up.set()
            self._found()
            await serving
        except Unavailable:
            logger.info("the master was lost; robots drive on, and new ones wait for it")
        finally:
            self._up.clear()
            serving.cancel()
            await asyncio.gather(serving, return_exceptions=True)
            await stream.close()

    async def call(
        self, method: Callable[Concatenate[Any, P], Coroutine[Any, Any, R]], *args: P.args, **named: P.kwargs
    ) -> R:
        """Call a method of the master, once it is reachable; raises the errors of the method.

        Raises
        ------
        Unavailable
            The master is not reachable, or was lost before it answered.
        """
        if not self._up.is_set():
            await self._wait()
        caller = self._caller
        if caller is None:
            raise Unavailable("the master is not reachable at the moment; try again")
        result = await caller.call(method, *args, **named)
        self._answered = self._clock()
        return result

    def tell(
        self, method: Callable[Concatenate[Any, P], Coroutine[Any, Any, None]], *args: P.args, **named: P.kwargs
    ) -> bool:
        """Call a method of the master without waiting; return false if it is not reachable."""
        if self._caller is None or not self._up.is_set():
            return False
        self._caller.tell(method, *args, **named)
        return True

    def hang_up(self) -> None:
        """Leave the master for another one that leads."""
        if self._caller is not None:
            self._caller.hang_up()

    async def _wait(self) -> None:
        try:
            async with asyncio.timeout(PATIENCE):
                await self._up.wait()
        except TimeoutError as error:
            raise Unavailable(f"no master was reachable within {PATIENCE:g} s; try again") from error


async def undone_if_cancelled(work: Coroutine[Any, Any, T], undo: Callable[[T], object]) -> T:
    """Return the result of work; if the caller is cancelled meanwhile, call ``undo`` with the result."""

    def finished(working: asyncio.Task[T]) -> None:
        if not working.cancelled() and working.exception() is None:
            undo(working.result())

    working = asyncio.create_task(work)
    try:
        return await asyncio.shield(working)
    except asyncio.CancelledError:
        working.add_done_callback(finished)
        raise
