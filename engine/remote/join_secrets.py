"""Join secrets: texts in files, which many machines use, in place of a ticket for each.

The cloud reads its files whenever a machine asks to join, so secrets are changed without a restart. A secret is never
sent: either end proves that it has it by a code (HMAC) over the whole exchange, the certificate of the server included.
A server in between, which has another certificate, learns nothing and cannot pose as either end.
"""

import hashlib
import hmac
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from engine.remote.authority import STANDBY
from ppaas.clock import Clock, epoch
from ppaas.errors import InvalidInput, NotPermitted, TooManyAttempts, Unavailable

# -- files -------------------------------------------------------------------------------------------------------------

SHORTEST, LONGEST = 32, 256
"""Number of characters of a secret; 32 of base64 have 192 bits, which nobody can guess."""

MOST_SECRETS = 8
"""Largest number of secrets of a file."""

MAX_FILE = 1 << 14
"""Largest size of a file [bytes]."""

UNTIL = "until="


@dataclass(frozen=True, slots=True)
class JoinSecret:
    """A secret and the time at which it expires [s since the epoch]; None for never."""

    text: str
    until: float | None


def read_secrets(path: Path) -> tuple[JoinSecret, ...]:
    """Return the secrets of a file: one a line, after it ``until=TIME`` if it expires; ``#`` begins a comment.

    Raises
    ------
    InvalidInput
        The file cannot be read, has no secret, or one that is invalid. No text has a secret.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_FILE + 1)
        lines = content.decode("ascii").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not all of it is ASCII"
        raise InvalidInput(f"the join secrets in {path} cannot be read: {reason}") from error
    if len(content) > MAX_FILE:
        raise InvalidInput(f"{path} is too large: a file of join secrets has at most {MAX_FILE} bytes")
    found = [_secret(words, f"{path}:{number}") for number, words in _numbered(lines)]
    if not 1 <= len(found) <= MOST_SECRETS:
        raise InvalidInput(f"{path} has {len(found)} join secrets: give 1 to {MOST_SECRETS}, one a line")
    return tuple(found)


def _numbered(lines: Iterable[str]) -> Iterable[tuple[int, list[str]]]:
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if words and not words[0].startswith("#"):
            yield number, words


def _secret(words: list[str], place: str) -> JoinSecret:
    text, *rest = words
    if not SHORTEST <= len(text) <= LONGEST:
        raise InvalidInput(f"{place}: a join secret has {SHORTEST} to {LONGEST} characters, not {len(text)}")
    if not rest:
        return JoinSecret(text, None)
    try:
        [option] = rest
        moment = datetime.fromisoformat(option.removeprefix(UNTIL))
    except ValueError:
        moment = datetime.min
    if not rest[0].startswith(UNTIL) or moment.tzinfo is None:
        raise InvalidInput(f"{place}: after a join secret only {UNTIL}TIME may follow, as until=2027-01-31T12:00:00Z")
    return JoinSecret(text, moment.astimezone(UTC).timestamp())


# -- proofs ------------------------------------------------------------------------------------------------------------


class JoinExchange(msgspec.Struct, frozen=True, array_like=True):
    """What either end proves that it has seen.

    Parameters
    ----------
    machine : str
        Name for which a certificate is requested.
    request : bytes
        Certificate signing request.
    asked, challenge : bytes
        Random numbers of the machine and of the cloud.
    cloud : str
        Fingerprint of the certificate of the server.
    """

    machine: str
    request: bytes
    asked: bytes
    challenge: bytes
    cloud: str


def proof_of_machine(secret: str, exchange: JoinExchange) -> bytes:
    """Return the code by which a machine proves that it has the secret."""
    return _code(secret, "ppaas join: machine", exchange)


def proof_of_cloud(secret: str, exchange: JoinExchange, issued: tuple[bytes, bytes]) -> bytes:
    """Return the code by which the cloud proves it, with the certificates that it sends."""
    return _code(secret, "ppaas join: cloud", exchange, *issued)


def is_proof(proof: bytes, expected: bytes) -> bool:
    """Compare codes in constant time."""
    return hmac.compare_digest(proof, expected)


def _code(secret: str, end: str, *signed: object) -> bytes:
    return hmac.digest(secret.encode(), msgspec.msgpack.encode((end, *signed)), hashlib.sha256)


# -- the cloud's secrets -----------------------------------------------------------------------------------------------


class JoinSecrets:
    """The secrets with which machines and standbys may join.

    Parameters
    ----------
    machines, standbys : Path, optional
        Files of secrets; None if there are none.
    clock : callable
        Time [s since the epoch].

    Raises
    ------
    InvalidInput
        As of ``read_secrets``.
    """

    def __init__(self, machines: Path | None = None, standbys: Path | None = None, clock: Clock = epoch) -> None:
        self._files = {False: machines, True: standbys}
        self._clock = clock
        for file in self._files.values():
            if file is not None:
                read_secrets(file)

    def proven(self, machine: str, is_right: Callable[[str], bool]) -> str:
        """Return the secret that a machine or a standby has proven to have.

        Parameters
        ----------
        machine : str
            Its name.
        is_right : callable
            Returns whether the proof was made with a secret.

        Raises
        ------
        NotPermitted
            It is none of the present ones, has expired, or is not for this kind.
        Unavailable
            The secrets cannot be read.
        """
        standby = machine.endswith(STANDBY)
        try:
            found, other = self._found(standby, is_right), self._found(not standby, is_right)
        except InvalidInput as error:
            raise Unavailable(str(error), public="the cloud cannot read its join secrets: see its log") from error
        if found is None and other is not None:
            raise NotPermitted(f"this join secret is for {'machines' if standby else 'standbys'} only")
        if found is None:
            raise NotPermitted("this join secret is unknown or was replaced: use the present one of the cloud")
        if found.until is not None and self._clock() > found.until:
            raise NotPermitted("this join secret has expired: use a newer one of the cloud")
        return found.text

    def _found(self, standby: bool, is_right: Callable[[str], bool]) -> JoinSecret | None:
        file = self._files[standby]
        return next((one for one in read_secrets(file) if is_right(one.text)), None) if file is not None else None


# -- wrong attempts ----------------------------------------------------------------------------------------------------

MOST_WRONG, WRONG_PERIOD = 10, 60.0
"""Number of wrong proofs from one address within a time [s], after which further ones of it are not looked at."""

MOST_ADDRESSES = 1024
"""Number of addresses whose wrong proofs are counted; the oldest is forgotten."""


class WrongProofs:
    """Counts wrong proofs by address.

    Parameters
    ----------
    clock : callable
        Time [s].
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._times: dict[str, list[float]] = {}

    def check(self, address: str) -> None:
        """Check that an address may try again.

        Raises
        ------
        TooManyAttempts
            There were too many wrong proofs.
        """
        recent = self._recent(address)
        if len(recent) >= MOST_WRONG:
            wait = recent[0] + WRONG_PERIOD - self._clock()
            raise TooManyAttempts(
                f"too many wrong join secrets came from {address}: try again in {wait:.0f} s", retry_after=wait
            )

    def note(self, address: str) -> None:
        """Note a wrong proof."""
        recent = [*self._recent(address), self._clock()]
        self._times.pop(address, None)
        self._times[address] = recent[-MOST_WRONG:]
        if len(self._times) > MOST_ADDRESSES:
            del self._times[next(iter(self._times))]

    def _recent(self, address: str) -> list[float]:
        return [time for time in self._times.get(address, ()) if self._clock() - time < WRONG_PERIOD]
