"""Access of an endpoint to its master: that of its own host, or the one that leads a cloud of other hosts."""

import asyncio
import enum
from collections.abc import Awaitable, Callable
from typing import Protocol

from engine.protocols.address import UnixAddress, parse_address
from engine.protocols.sockets import Streams, dial
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.masters import Masters
from engine.remote.membership import Membership
from ppaas.errors import Conflict


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
    """

    secret: str

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

    def __init__(self, address: UnixAddress, secret: str, is_replaced: Callable[[], Awaitable[bool]]) -> None:
        self.secret = secret
        self._address = address
        self._is_replaced = is_replaced

    async def dial(self) -> Streams:
        """Connect to the master."""
        return await dial(self._address)

    async def silence(self) -> Silence:
        """Return whether another process leads: its endpoints are those of its own host."""
        return Silence.REPLACED if await self._is_replaced() else Silence.UNKNOWN


class FarMaster:
    """Access to the master that leads the cloud of a joined machine.

    Parameters
    ----------
    membership : Membership
        The machine, and the cloud that it has joined.
    settings : ClusterSettings
        Settings of the cloud with which this endpoint started.
    """

    secret = ""

    def __init__(self, membership: Membership, settings: ClusterSettings) -> None:
        self._membership = membership
        self._settings = _lasting(settings)
        self._masters = Masters(membership)
        self._masters.note(settings.masters)

    async def dial(self) -> Streams:
        """Find the master that leads, and connect to it."""
        self._masters.read_again()
        if _lasting(await self._masters.settings()) != self._settings:
            raise Conflict("the cloud was started with other settings; this endpoint starts again with them")
        address = parse_address(self._masters.current)
        context = await asyncio.to_thread(self._membership.identity.client_context, "endpoint")
        return await dial(address, context)

    async def silence(self) -> Silence:
        """Return whether a master at another address leads."""
        self._masters.read_again()
        return Silence.MOVED if await self._masters.another_leads() else Silence.UNKNOWN


def _lasting(settings: ClusterSettings) -> tuple[object, ...]:
    """Return the settings that an endpoint uses, which may not change while it runs."""
    return settings.store, settings.map_store, settings.runs.allowed, settings.release, settings.serves
