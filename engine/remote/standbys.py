"""The leader's end of the connections of standbys: sends them its files, and sends machines their addresses."""

import asyncio
import logging
from collections.abc import Callable
from pathlib import Path

import msgspec

from engine.leadership.mandate import Mandate, SoleMaster
from engine.protocols.address import TlsAddress
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import Refusal
from engine.remote.known_masters import KnownMasters
from engine.remote.replica import in_order, read_files, signature
from ppaas import __version__
from ppaas.errors import Conflict, InvalidInput, PPaaSError

logger = logging.getLogger(__name__)

HELLO_TIMEOUT = 5.0
"""Time within which a connected standby must say hello [s]."""

PERIOD = 1.0
"""Time between two looks for changed files [s]."""

MAX_HELLO = 1 << 12
"""Largest message of a standby [bytes]."""

MOST_STANDBYS = 8
"""Largest number of connected standbys."""


class StandbyHello(msgspec.Struct, tag="standby_hello"):
    """A standby connects. At ``host`` and ``port`` it listens for machines once it leads; an empty host is its address.

    ``release`` is the release of this program that it runs.
    """

    host: str
    port: int
    release: str


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
        if hello.release != __version__:
            raise Conflict(f"the cloud runs release {__version__}, and the standby {hello.release[:64]!r}")
        if self._connected > MOST_STANDBYS:
            raise Conflict(f"{MOST_STANDBYS} processes stand by already")
        host = hello.host or str(writer.get_extra_info("peername")[0])
        if self._masters.note((str(TlsAddress(host, hello.port)),)):
            self._announce()

    async def _serve(self, stream: FrameStream[StandbyHello]) -> None:
        """Send files until the standby disconnects; it sends nothing more."""
        sending = asyncio.create_task(self._send(stream))
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
            if now != seen:
                files, seen = await asyncio.to_thread(read_files, self._data), now
                for name in in_order({name for name, content in files.items() if sent.get(name) != content}):
                    await stream.send(ReplicaFile(name, files[name]))
                sent, names = files, tuple(files)
            await stream.send(ReplicaComplete(self.mandate.epoch, names))
            await asyncio.sleep(self._period)
