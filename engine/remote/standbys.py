"""Connections between a leader and its standbys.

The leader sends standbys the files that they need to lead, and machines the addresses of all masters. A standby keeps a
copy of these files.
"""

import asyncio
import contextlib
import logging
from collections.abc import Callable
from pathlib import Path

import msgspec

from engine.leadership.leadership import Mandate, SoleMaster
from engine.protocols.address import TlsAddress
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import Refusal, error_of
from engine.protocols.sockets import dial
from engine.protocols.versions import OWN, Protocols, agree
from engine.remote.authority import STANDBY, Authority
from engine.remote.joining import read_ticket
from engine.remote.masters import KnownMasters
from engine.remote.membership import Membership, enrol, join, membership_in
from engine.remote.replica import LAST, MACHINES, in_order, keep_only, read_files, signature, write_file
from ppaas import __version__
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError, Unavailable

logger = logging.getLogger(__name__)


# -- messages ----------------------------------------------------------------------------------------------------------

MAX_HELLO = 1 << 12
"""Largest message of a standby [bytes]."""


class StandbyHello(msgspec.Struct, tag="standby_hello"):
    """A standby connects. At ``host`` and ``port`` it listens for machines once it leads; an empty host is its address.

    ``release`` is the release of this program that it runs, and ``protocols`` are those that it speaks.
    """

    host: str
    port: int
    release: str
    protocols: Protocols | None = None


class ReplicaFile(msgspec.Struct, tag="replica_file"):
    """A file of the leader that is new or has changed."""

    name: str
    content: bytes


class ReplicaComplete(msgspec.Struct, tag="replica_complete"):
    """All files were sent. Repeated every `PERIOD` seconds, so that a standby notices a lost connection.

    ``names`` are the names of all files after a change, else None. A standby removes its others: a certificate may have
    been withdrawn while it was away.
    """

    epoch: int
    names: tuple[str, ...] | None = None


class StandbyRefused(msgspec.Struct, tag="standby_refused"):
    """The standby cannot take over from this leader."""

    refusal: Refusal


ToStandby = ReplicaFile | ReplicaComplete | StandbyRefused


# -- the leader's end --------------------------------------------------------------------------------------------------

HELLO_TIMEOUT = 5.0
"""Time within which a connected standby must say hello [s]."""

PERIOD = 1.0
"""Time between two looks for changed files [s]."""

MOST_STANDBYS = 8
"""Largest number of connected standbys."""


class Standbys:
    """The connected standbys.

    Parameters
    ----------
    data : Path
        Data folder of the leader.
    masters : KnownMasters
        Addresses of all masters; the standbys' are added.
    announce : callable
        Called when an address was added.
    period : float
        Time between two looks for changed files [s].

    Attributes
    ----------
    mandate : Mandate
        Leadership of this process: nothing is sent without it.
    """

    def __init__(
        self, data: Path, masters: KnownMasters, announce: Callable[[], None], *, period: float = PERIOD
    ) -> None:
        self._data = data
        self._masters = masters
        self._announce = announce
        self._period = period
        self._connected = 0
        self.mandate: Mandate = SoleMaster()

    async def connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, name: str) -> None:
        """Serve the connection of a standby; ``name`` is that in its certificate."""
        stream: FrameStream[StandbyHello] = FrameStream(reader, writer, StandbyHello, most=MAX_HELLO)
        self._connected += 1
        try:
            async with asyncio.timeout(HELLO_TIMEOUT):
                hello = await stream.receive()
            if hello is not None:
                self._admit(hello, writer)
                logger.info("%s stands by for this cloud", name)
                await self._serve(stream)
                logger.warning("%s does not stand by any more", name)
        except (PPaaSError, TimeoutError) as error:
            logger.warning("%s cannot stand by: %s", name, str(error) or "it said no hello in time")
            refusal = error if isinstance(error, PPaaSError) else InvalidInput("no hello in time")
            stream.write(StandbyRefused(Refusal(refusal.slug, str(refusal))))
        finally:
            self._connected -= 1
            await stream.close()

    def _admit(self, hello: StandbyHello, writer: asyncio.StreamWriter) -> None:
        agree("the standby", hello.release, hello.protocols)
        if self._connected > MOST_STANDBYS:
            raise Conflict(f"{MOST_STANDBYS} processes stand by already")
        host = hello.host or str(writer.get_extra_info("peername")[0])
        if self._masters.note((str(TlsAddress(host, hello.port)),)):
            self._announce()

    async def _serve(self, stream: FrameStream[StandbyHello]) -> None:
        """Send files until the standby disconnects; it sends nothing more."""
        sending = asyncio.create_task(self._send(stream))
        # It ends when the standby disconnects.
        reading = asyncio.create_task(stream.receive())
        try:
            await asyncio.wait((sending, reading), return_when=asyncio.FIRST_COMPLETED)
            if sending.done():
                sending.result()
        finally:
            for task in (sending, reading):
                task.cancel()
            await asyncio.gather(sending, reading, return_exceptions=True)

    async def _send(self, stream: FrameStream[StandbyHello]) -> None:
        sent: dict[str, bytes] = {}
        seen: tuple[int, ...] = ()
        while self.mandate.leads():
            now, names = await asyncio.to_thread(signature, self._data), None
            # Files are read only if one has changed since.
            if now != seen:
                files, seen = await asyncio.to_thread(read_files, self._data), now
                for name in in_order({name for name, content in files.items() if sent.get(name) != content}):
                    await stream.send(ReplicaFile(name, files[name]))
                sent, names = files, tuple(files)
            await stream.send(ReplicaComplete(self.mandate.epoch, names))
            await asyncio.sleep(self._period)


# -- the standby's end -------------------------------------------------------------------------------------------------

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
            await stream.send(StandbyHello(host, self._listen.port, __version__, OWN))
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
