"""How a machine of another host joins: it shows a ticket, and gets a certificate for a key that never leaves it.

Both ends are here: the desk in the cloud, and what a machine does at it.
"""

import asyncio
import logging

import msgspec

from engine.protocols.framing import FrameStream
from engine.protocols.robot_link import Refusal
from engine.protocols.sockets import dial
from engine.protocols.tls_identity import stranger_context
from engine.remote.authority import Authority
from engine.remote.certificates import fingerprint
from engine.remote.tickets import Ticket, Tickets
from ppaas.errors import Conflict, NotPermitted, PPaaSError, Unavailable, rebuild

logger = logging.getLogger(__name__)

PATIENCE = 5.0
"""Seconds that either end waits for the other."""


MAX_JOIN = 1 << 14
"""Bytes that somebody may say who has no certificate."""


class Join(msgspec.Struct, tag="join"):
    """A machine wants to join; ``request`` is for its certificate (PKCS #10, PEM)."""

    secret: str
    machine: str
    request: bytes


class Joined(msgspec.Struct, tag="joined"):
    """It has; its certificate and that of the authority, in PEM."""

    certificate: bytes
    authority: bytes


class NotJoined(msgspec.Struct, tag="not_joined"):
    """It has not."""

    refusal: Refusal


class JoinServer:
    """Serves machines that have a ticket.

    Parameters
    ----------
    authority : Authority
        Issues their certificates.
    tickets : Tickets
        That were not used yet.
    taken : frozenset of str
        Names that no machine of another host may have.
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
                asked = await stream.receive()
            if asked is not None:
                await stream.send(await asyncio.to_thread(self._answer, asked))
        except (PPaaSError, TimeoutError) as error:
            logger.warning("somebody did not ask to join: %s", error or "it said nothing")
        finally:
            await stream.close()

    def _answer(self, asked: Join) -> Joined | NotJoined:
        try:
            certificate = self._admit(asked)
        except PPaaSError as error:
            logger.warning("a machine that calls itself %r did not join: %s", asked.machine[:64], error)
            return NotJoined(Refusal(error.slug, str(error)))
        logger.info("machine %s has got its certificate", asked.machine)
        return Joined(certificate, self._authority.pem)

    def _admit(self, asked: Join) -> bytes:
        named = self._tickets.use(asked.secret, asked.machine)
        if asked.machine in self._taken or (not named and self._authority.has_issued(asked.machine)):
            raise Conflict(
                f"a machine is called {asked.machine!r} already: join by a new ticket with another --name, "
                f"or by one made with --name {asked.machine} if it is the same machine"
            )
        return self._authority.issue(asked.machine, asked.request)


async def ask_to_join(ticket: Ticket, machine: str, request: bytes) -> Joined:
    """Show a ticket; return the certificate.

    Raises
    ------
    NotPermitted
        Whoever answers is not the cloud that the ticket is of; it was told nothing.
    Unavailable
        Nobody answers.
    PPaaSError
        What the cloud says instead.
    """
    reader, writer = await dial(ticket.address, stranger_context())
    shown = writer.get_extra_info("ssl_object").getpeercert(binary_form=True)
    if fingerprint(shown) != ticket.cloud:
        writer.transport.abort()
        raise NotPermitted(f"what answers at {ticket.address} is not the cloud that made this ticket")
    stream: FrameStream[Joined | NotJoined] = FrameStream(reader, writer, Joined | NotJoined)
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
        raise Unavailable(f"the cloud at {ticket.address} hung up; try again")
    raise rebuild(answer.refusal.slug, answer.refusal.text)
