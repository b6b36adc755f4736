"""Joining with a secret, which many machines have: the server in the cloud and the client on the machine.

A machine sends its certificate signing request, gets a challenge, and answers with its proof; the cloud answers with
the certificates and its own proof. A name that was given out this way may be given out again, unless its machine is
connected: a computer may lose its folder. A name that was given out for a ticket may not.
"""

import asyncio
import logging
import secrets
from collections.abc import Callable
from pathlib import Path

from engine.protocols.address import TlsAddress
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import Refusal, error_of
from engine.protocols.sockets import dial, fingerprint
from engine.protocols.tls_identity import stranger_context
from engine.remote.authority import Authority
from engine.remote.join_secrets import (
    JoinExchange,
    JoinSecrets,
    WrongProofs,
    is_proof,
    proof_of_cloud,
    proof_of_machine,
    read_secrets,
)
from engine.remote.joining import (
    MAX_JOIN,
    PATIENCE,
    FromStranger,
    JoinBySecret,
    JoinChallenge,
    Joined,
    JoinedBySecret,
    JoinProof,
    NotJoined,
)
from ppaas.clock import Clock, monotonic
from ppaas.errors import Conflict, MalformedMessage, NotPermitted, PPaaSError, Unavailable

logger = logging.getLogger(__name__)

NONCE = 32
"""Length of the random numbers [bytes]."""


# -- the cloud's end ---------------------------------------------------------------------------------------------------


class SecretJoins:
    """Issues certificates to machines that prove to have a secret.

    Parameters
    ----------
    authority : Authority
        Issues the certificates.
    known : JoinSecrets
        The secrets.
    taken : frozenset of str
        Names that machines of other hosts must not have.
    is_connected : callable
        Returns whether a machine of a name is connected.
    clock : callable
        Time [s].
    """

    def __init__(
        self,
        authority: Authority,
        known: JoinSecrets,
        taken: frozenset[str],
        is_connected: Callable[[str], bool],
        clock: Clock = monotonic,
    ) -> None:
        self._authority = authority
        self._known = known
        self._taken = taken
        self._is_connected = is_connected
        self._wrong = WrongProofs(clock)

    async def serve(self, stream: FrameStream[FromStranger], asked: JoinBySecret, address: str) -> None:
        """Serve a connection that has begun with a request; ``address`` is that of the other host.

        Raises
        ------
        MalformedMessage
            The peer violates the protocol.
        TimeoutError
            It sends no proof in time.
        """
        if len(asked.nonce) != NONCE:
            raise MalformedMessage(f"the random number of a request to join has {len(asked.nonce)} bytes, not {NONCE}")
        challenge = secrets.token_bytes(NONCE)
        await stream.send(JoinChallenge(challenge))
        async with asyncio.timeout(PATIENCE):
            proof = await stream.receive()
        if proof is None:
            return
        if not isinstance(proof, JoinProof):
            raise MalformedMessage("a challenge was not answered with a proof")
        exchange = JoinExchange(asked.machine, asked.request, asked.nonce, challenge, self._authority.fingerprint)
        await stream.send(await self._answer(exchange, proof.proof, address))

    async def _answer(self, exchange: JoinExchange, proof: bytes, address: str) -> JoinedBySecret | NotJoined:
        try:
            self._wrong.check(address)
            answer = await asyncio.to_thread(self._admit, exchange, proof)
        except PPaaSError as error:
            if isinstance(error, NotPermitted):
                self._wrong.note(address)
            logger.warning(
                "the request of %r at %s to join with a secret was refused: %s", exchange.machine[:64], address, error
            )
            return NotJoined(Refusal(error.slug, error.public))
        logger.info("%s at %s joined with a secret", exchange.machine, address)
        return answer

    def _admit(self, exchange: JoinExchange, proof: bytes) -> JoinedBySecret:
        machine = exchange.machine
        secret = self._known.proven(machine, lambda one: is_proof(proof, proof_of_machine(one, exchange)))
        if machine in self._taken or (
            self._authority.has_issued(machine) and not self._authority.has_joined_by_secret(machine)
        ):
            raise Conflict(
                f"there is a machine named {machine!r} already, which joined with a ticket: use another --name"
            )
        if self._is_connected(machine):
            raise Conflict(f"a machine named {machine!r} is connected: end it first, or use another --name")
        issued = self._authority.issue(machine, exchange.request, by_secret=True), self._authority.pem
        return JoinedBySecret(*issued, proof_of_cloud(secret, exchange, issued))


# -- the machine's end -------------------------------------------------------------------------------------------------


FromCloud = JoinChallenge | JoinedBySecret | NotJoined


async def join_masters(
    masters: tuple[TlsAddress, ...], file: Path, machine: str, request: bytes
) -> tuple[Joined, TlsAddress]:
    """Request a certificate of the first master that answers, with each secret of a file until one is right.

    Returns
    -------
    tuple
        The certificates, and the address of the master.

    Raises
    ------
    InvalidInput
        The secrets cannot be read.
    Unavailable
        No master answers.
    PPaaSError
        The error that the cloud answered with.
    """
    known = await asyncio.to_thread(read_secrets, file)
    problems = []
    for address in masters:
        try:
            return await _join(address, [one.text for one in known], machine, request), address
        except Unavailable as error:
            problems.append(str(error))
    raise Unavailable("; ".join(problems))


async def _join(address: TlsAddress, known: list[str], machine: str, request: bytes) -> Joined:
    for secret in known[:-1]:
        try:
            return await request_by_secret(address, secret, machine, request)
        except NotPermitted:
            continue
    return await request_by_secret(address, known[-1], machine, request)


async def request_by_secret(address: TlsAddress, secret: str, machine: str, request: bytes) -> Joined:
    """Request a certificate of the cloud with a secret.

    Raises
    ------
    NotPermitted
        The server has not proven that it has the secret; or the error that the cloud answered with.
    Unavailable
        The cloud does not answer.
    PPaaSError
        The error that the cloud answered with.
    """
    reader, writer = await dial(address, stranger_context())
    shown = fingerprint(writer.get_extra_info("ssl_object").getpeercert(binary_form=True))
    stream: FrameStream[FromCloud] = FrameStream(reader, writer, FromCloud, most=MAX_JOIN)
    nonce = secrets.token_bytes(NONCE)
    try:
        async with asyncio.timeout(PATIENCE):
            await stream.send(JoinBySecret(machine, request, nonce))
            answer = await stream.receive()
            if isinstance(answer, JoinChallenge):
                exchange = JoinExchange(machine, request, nonce, answer.nonce, shown)
                await stream.send(JoinProof(proof_of_machine(secret, exchange)))
                return _checked(await stream.receive(), secret, exchange, address)
    except TimeoutError as error:
        raise Unavailable(f"the cloud at {address} did not answer within {PATIENCE:g} s") from error
    finally:
        await stream.close()
    raise _refused(answer, address)


def _checked(answer: FromCloud | None, secret: str, exchange: JoinExchange, address: TlsAddress) -> Joined:
    if not isinstance(answer, JoinedBySecret):
        raise _refused(answer, address)
    issued = answer.certificate, answer.authority
    if not is_proof(answer.proof, proof_of_cloud(secret, exchange, issued)):
        raise NotPermitted(f"the server at {address} has not proven that it has the join secret: it is another cloud")
    return Joined(*issued)


def _refused(answer: FromCloud | None, address: TlsAddress) -> PPaaSError:
    if answer is None:
        return Unavailable(f"the cloud at {address} closed the connection; try again")
    if isinstance(answer, NotJoined):
        return error_of(answer.refusal)
    return NotPermitted(f"the server at {address} does not answer as a cloud does")
