"""Access of an endpoint to its master, and access to a master on the same host."""

import enum
from collections.abc import Awaitable, Callable
from typing import Protocol

from engine.protocols.address import UnixAddress
from engine.protocols.sockets import Streams, dial


class Silence(enum.Enum):
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

    async def silence(self) -> Silence:
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

    async def silence(self) -> Silence:
        """Return whether another process leads: its endpoints are on its own host."""
        return Silence.REPLACED if await self._is_replaced() else Silence.UNKNOWN
