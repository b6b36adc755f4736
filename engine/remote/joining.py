"""Joining: a machine of another host shows a ticket and gets a certificate for a key that never leaves it.

This module has both ends: the server in the cloud and the client on the machine. ``secret_joining`` has what differs
for machines with a secret, which many share.

Tickets are made by users who may write to the data folder of the cloud, its administrators; no request over the network
can make one. They are valid once, for a limited time. The folder only contains a hash of each secret.
"""

import asyncio
import base64
import hashlib
import logging
import secrets
from collections.abc import Awaitable, Callable
from pathlib import Path

import msgspec

from engine.processes.private_files import write_private
from engine.protocols.address import TlsAddress
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import Refusal, error_of
from engine.protocols.sockets import dial_pinned
from engine.protocols.tls_identity import stranger_context
from engine.remote.authority import STANDBY, Authority, check_name
from ppaas.clock import Clock, epoch
from ppaas.decoding import from_json, from_msgpack
from ppaas.errors import Conflict, InvalidInput, MalformedMessage, NotPermitted, PPaaSError, Unavailable

logger = logging.getLogger(__name__)


# -- tickets -----------------------------------------------------------------------------------------------------------

PREFIX = "ppaas-join-"


class Ticket(msgspec.Struct, frozen=True, array_like=True):
    """A ticket as it is given to a machine.

    Parameters
    ----------
    host, port
        Address of the cloud for machines.
    cloud : str
        SHA-256 of the cloud's certificate, in hexadecimal; the machine does not send the secret to any other server.
    secret : str
        Proof that an administrator has invited the machine.
    machine : str, optional
        Name of the machine that may use it; None for any.
    """

    host: str
    port: int
    cloud: str
    secret: str
    machine: str | None = None

    def __str__(self) -> str:
        return PREFIX + base64.urlsafe_b64encode(msgspec.msgpack.encode(self)).decode().rstrip("=")

    @property
    def address(self) -> TlsAddress:
        """Address of the cloud for machines."""
        return TlsAddress(self.host, self.port)


class _TicketFile(msgspec.Struct, frozen=True):
    """The cloud's record of a ticket: its expiry [s since the epoch], and the machine that may use it (None: any)."""

    until: float
    machine: str | None


def read_ticket(text: str) -> Ticket:
    """Decode a ticket.

    Raises
    ------
    InvalidInput
        The text is not a ticket.
    """
    body = text.strip().removeprefix(PREFIX)
    try:
        packed = base64.b64decode(body + "=" * (-len(body) % 4), b"-_", validate=True)
        return from_msgpack(packed, Ticket)
    except (ValueError, msgspec.DecodeError) as error:
        raise InvalidInput("not a ticket: copy the whole text that 'ppaas machine ticket' printed") from error


class Tickets:
    """The unused tickets of a cloud.

    Parameters
    ----------
    folder : Path
        Folder with a file for each ticket; created if it does not exist.
    clock : callable
        Time [s since the epoch].
    """

    def __init__(self, folder: Path, clock: Clock = epoch) -> None:
        self._folder = folder
        self._clock = clock

    def make(self, address: TlsAddress, cloud: str, *, valid: float, machine: str | None = None) -> Ticket:
        """Make a ticket.

        Parameters
        ----------
        address : TlsAddress
            Address by which the machine reaches the cloud.
        cloud : str
            SHA-256 of the cloud's certificate.
        valid : float
            Time for which the ticket is valid [s].
        machine : str, optional
            Name of the machine that may use it, also if it has joined before. Default: any new machine.

        Raises
        ------
        InvalidInput
            The name of the machine is invalid, or the folder cannot be used.
        """
        if machine is not None:
            check_name(machine)
        ticket = Ticket(address.host, address.port, cloud, secrets.token_urlsafe(24), machine)
        try:
            self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            write_private(self._path(ticket.secret), msgspec.json.encode(_TicketFile(self._clock() + valid, machine)))
        except OSError as error:
            raise InvalidInput(f"the ticket cannot be stored in {self._folder}: {error}") from error
        return ticket

    def use(self, secret: str, machine: str) -> bool:
        """Use up a ticket; return whether it was made for a machine by name.

        Raises
        ------
        NotPermitted
            The ticket is unknown, used, expired, or for another machine.
        """
        path = self._path(secret)
        try:
            known = from_json(path.read_bytes(), _TicketFile)
            if known.machine != machine and (known.machine is not None or machine.endswith(STANDBY)):
                raise NotPermitted(
                    f"this ticket is for machine {known.machine!r}: join with --name {known.machine}"
                    if known.machine is not None
                    else "this ticket is for a machine: make one with 'ppaas machine ticket --standby NAME'"
                )
            path.unlink()  # if two machines use it at once, one does not find it any more
        except FileNotFoundError as error:
            raise NotPermitted("this ticket is unknown or was used: make a new one") from error
        if self._clock() > known.until:
            raise NotPermitted("this ticket has expired: make a new one")
        return known.machine is not None

    def _path(self, secret: str) -> Path:
        return self._folder / f"{hashlib.sha256(secret.encode()).hexdigest()}.json"


# -- the exchange ------------------------------------------------------------------------------------------------------

PATIENCE = 5.0
"""Time that either end waits for the other [s]."""

MAX_JOIN = 1 << 14
"""Largest message from a client without a certificate [bytes]."""


class Join(msgspec.Struct, tag="join"):
    """Request to join; ``request`` is the certificate signing request (PKCS #10, PEM)."""

    secret: str
    machine: str
    request: bytes


class Joined(msgspec.Struct, tag="joined"):
    """Accepted: the certificates of the machine and of the authority, in PEM."""

    certificate: bytes
    authority: bytes


class NotJoined(msgspec.Struct, tag="not_joined"):
    """Refused."""

    refusal: Refusal


class JoinBySecret(msgspec.Struct, tag="join_by_secret"):
    """Request to join with a secret, which is not sent; ``nonce`` is a random number."""

    machine: str
    request: bytes
    nonce: bytes


class JoinChallenge(msgspec.Struct, tag="join_challenge"):
    """The random number of the cloud."""

    nonce: bytes


class JoinProof(msgspec.Struct, tag="join_proof"):
    """Proof of the machine that it has the secret."""

    proof: bytes


class JoinedBySecret(msgspec.Struct, tag="joined_by_secret"):
    """Accepted, with the proof of the cloud that it has the secret."""

    certificate: bytes
    authority: bytes
    proof: bytes


FromStranger = Join | JoinBySecret | JoinProof

ServeBySecret = Callable[[FrameStream[FromStranger], JoinBySecret, str], Awaitable[None]]
"""Serves a connection that has begun with a request; the last argument is the address of the other host."""


class JoinServer:
    """Issues certificates to machines that have a ticket.

    Parameters
    ----------
    authority : Authority
        Issues the certificates.
    tickets : Tickets
        The unused tickets.
    taken : frozenset of str
        Names that machines of other hosts must not have.
    by_secret : callable
        Serves machines with a secret.
    """

    def __init__(self, authority: Authority, tickets: Tickets, taken: frozenset[str], by_secret: ServeBySecret) -> None:
        self._authority = authority
        self._tickets = tickets
        self._taken = taken
        self._by_secret = by_secret

    async def connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve a connection."""
        stream: FrameStream[FromStranger] = FrameStream(reader, writer, FromStranger, most=MAX_JOIN)
        try:
            async with asyncio.timeout(PATIENCE):
                request = await stream.receive()
            match request:
                case Join():
                    await stream.send(await asyncio.to_thread(self._answer, request))
                case JoinBySecret():
                    await self._by_secret(stream, request, str(writer.get_extra_info("peername")[0]))
                case JoinProof():
                    raise MalformedMessage("it sent a proof before a request")
        except (PPaaSError, TimeoutError) as error:
            logger.warning("a client sent no valid request to join: %s", str(error) or "it timed out")
        finally:
            await stream.close()

    def _answer(self, request: Join) -> Joined | NotJoined:
        try:
            certificate = self._admit(request)
        except PPaaSError as error:
            logger.warning("the request of machine %r to join was refused: %s", request.machine[:64], error)
            return NotJoined(Refusal(error.slug, str(error)))
        logger.info("machine %s has its certificate", request.machine)
        return Joined(certificate, self._authority.pem)

    def _admit(self, request: Join) -> bytes:
        named = self._tickets.use(request.secret, request.machine)
        if request.machine in self._taken or (not named and self._authority.has_issued(request.machine)):
            raise Conflict(
                f"there is a machine named {request.machine!r} already: join with a new ticket and another --name; "
                f"if it is the same machine, join with a ticket made with --name {request.machine}"
            )
        return self._authority.issue(request.machine, request.request)


async def request_certificate(ticket: Ticket, machine: str, request: bytes) -> Joined:
    """Request a certificate with a ticket.

    Raises
    ------
    NotPermitted
        The server is not the cloud that made the ticket; nothing was sent to it.
    Unavailable
        The cloud does not answer.
    PPaaSError
        The error that the cloud answered with.
    """
    try:
        streams = await dial_pinned(ticket.address, stranger_context(), ticket.cloud)
    except NotPermitted as error:
        raise NotPermitted(f"the server at {ticket.address} is not the cloud that made this ticket") from error
    stream: FrameStream[Joined | NotJoined] = FrameStream(*streams, Joined | NotJoined)
    try:
        async with asyncio.timeout(PATIENCE):
            await stream.send(Join(ticket.secret, machine, request))
            answer = await stream.receive()
    except TimeoutError as error:
        raise Unavailable(f"the cloud at {ticket.address} did not answer within {PATIENCE:g} s") from error
    finally:
        await stream.close()
    if isinstance(answer, Joined):
        return answer
    if answer is None:
        raise Unavailable(f"the cloud at {ticket.address} closed the connection; try again")
    raise error_of(answer.refusal)
