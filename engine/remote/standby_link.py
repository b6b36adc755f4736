"""The standby's end of its connection to the leader: keeps a copy of the files that it needs to lead."""

import asyncio
import contextlib
import logging
from pathlib import Path

from engine.protocols.address import TlsAddress
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import error_of
from engine.protocols.sockets import dial
from engine.remote.authority import STANDBY, Authority
from engine.remote.known_masters import KnownMasters
from engine.remote.membership import Membership, enrol, join, membership_in
from engine.remote.replica import LAST, MACHINES, keep_only, write_file
from engine.remote.standbys import PERIOD, ReplicaComplete, ReplicaFile, StandbyHello, StandbyRefused, ToStandby
from engine.remote.tickets import read_ticket
from ppaas import __version__
from ppaas.errors import InvalidInput, NotFound, PPaaSError, Unavailable

logger = logging.getLogger(__name__)

FOLDER = "standby"
"""Folder in the data folder with the certificate of a standby."""

DIAL_TIMEOUT = 2.0
"""Time limit to connect to one master [s]: one that is stopped accepts connections, and says nothing."""

RETRY = 0.5
"""Time between two attempts to reach the leader [s]."""

MISSED = 4
"""Number of periods without a message after which a connection counts as lost."""

EVERYWHERE = ("0.0.0.0", "::")


async def membership_of(data: Path, ticket: str, name: str) -> Membership | None:
    """Return the certificate of a standby and the address of a master; None if no other one is known.

    A standby gets its certificate with a ticket. One that has the files of the cloud already, as a leader that was
    replaced has, issues it itself.

    Parameters
    ----------
    data : Path
        Its data folder.
    ticket : str
        The ticket; empty if there is none.
    name : str
        Name of this host, without a ticket.

    Raises
    ------
    InvalidInput
        There is no ticket, and the data folder has no files of the cloud; or the ticket is for a machine.
    PPaaSError
        The error of ``join``.
    """
    folder = data / FOLDER
    if ticket:
        machine = read_ticket(ticket).machine
        if machine is None or not machine.endswith(STANDBY):
            raise InvalidInput("this ticket is for a machine: make one with 'ppaas machine ticket --standby NAME'")
        return await join(folder, ticket, machine)
    with contextlib.suppress(NotFound):
        return membership_in(folder)
    if not (data / LAST).exists():
        raise InvalidInput(
            "a standby that listens for machines needs a ticket of the leader once: run 'ppaas machine ticket "
            "--standby NAME' on the leader's host, and give its output to --standby"
        )
    masters = KnownMasters(data / MACHINES).addresses
    return enrol(folder, Authority(data / MACHINES), f"{name}{STANDBY}", masters[0]) if masters else None


class StandbyLink:
    """Connection to the current leader.

    Parameters
    ----------
    data : Path
        Data folder, in which the leader's files are stored.
    membership : Membership
        Certificate, and the address of one master.
    listen : TlsAddress
        Address at which this process listens for machines once it leads.
    """

    def __init__(self, data: Path, membership: Membership, listen: TlsAddress) -> None:
        self._data = data
        self._membership = membership
        self._listen = listen
        self.complete = asyncio.Event()

    async def run(self) -> None:
        """Copy the leader's files until cancelled; ``complete`` is set once all are there."""
        said = ""
        while True:
            for address in self._addresses():
                try:
                    await self._follow(address)
                except (PPaaSError, TimeoutError, OSError) as error:
                    text = f"{address}: {error or 'no answer in time'}"
                    logger.log(logging.DEBUG if isinstance(error, Unavailable) or text == said else logging.WARNING,
                               "the leader's files cannot be copied from %s", text)  # fmt: skip
                    said = text
            await asyncio.sleep(RETRY)

    def _addresses(self) -> list[TlsAddress]:
        others = KnownMasters(self._data / MACHINES).addresses
        return list(dict.fromkeys((self._membership.cloud, *others)))

    async def _follow(self, address: TlsAddress) -> None:
        async with asyncio.timeout(DIAL_TIMEOUT):
            streams = await dial(address, self._membership.identity.client_context("standby"))
        stream: FrameStream[ToStandby] = FrameStream(*streams, ToStandby)
        try:
            host = "" if self._listen.host in EVERYWHERE else self._listen.host
            await stream.send(StandbyHello(host, self._listen.port, __version__))
            while await self._take(stream):
                continue
        finally:
            stream.abort()

    async def _take(self, stream: FrameStream[ToStandby]) -> bool:
        """Take the next message; return whether there was one."""
        async with asyncio.timeout(MISSED * PERIOD):
            message = await stream.receive()
        match message:
            case ReplicaFile():
                await asyncio.to_thread(write_file, self._data, message.name, message.content)
            case ReplicaComplete():
                if message.names is not None:
                    await asyncio.to_thread(keep_only, self._data, message.names)
                self.complete.set()
            case StandbyRefused():
                raise error_of(message.refusal)
        return message is not None
