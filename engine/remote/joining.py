"""Joining: a machine of another host shows a ticket and gets a certificate for a key that never leaves it.

This module has both ends: the server in the cloud and the client on the machine.
"""

import asyncio
import logging

import msgspec

from engine.protocols.framing import FrameStream
from engine.protocols.pinned import dial_pinned
from engine.protocols.refusals import Refusal, error_of
from engine.protocols.tls_identity import stranger_context
from engine.remote.authority import Authority
from engine.remote.tickets import Ticket, Tickets
from ppaas.errors import Conflict, NotPermitted, PPaaSError, Unavailable

logger = logging.getLogger(__name__)

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
    """

    def __init__(self, authority: Authority, tickets: Tickets, taken: frozenset[str]) -> None:
        self._authority = authority
        self._tickets = tickets
        self._taken = taken

    async def connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve a connection."""
        stream: FrameStream[Join] = FrameStream(reader, writer, Join, most=MAX_JOIN)
        try:
            async with asyncio.timeout(PATIENCE):
                request = await stream.receive()
            if request is not None:
                await stream.send(await asyncio.to_thread(self._answer, request))
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
