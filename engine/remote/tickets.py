"""Tickets, with which a machine joins the cloud: valid once, for a limited time.

Tickets are made by users who may write to the data folder of the cloud, its administrators; no request over the network
can make one. The folder only contains a hash of each secret.
"""

import base64
import hashlib
import secrets
from pathlib import Path

import msgspec

from engine.processes.private_files import write_private
from engine.protocols.address import TlsAddress
from engine.remote.authority import STANDBY, check_name
from ppaas.clock import Clock, epoch
from ppaas.decoding import from_json, from_msgpack
from ppaas.errors import InvalidInput, NotPermitted

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
