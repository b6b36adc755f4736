"""Tickets: who has one may have a machine join the cloud, once and soon.

A ticket is made by whoever may write into the data folder of the cloud: that is its administrator anyway, and no
request over the network can make one. Of its secret the folder has a hash alone.
"""

import base64
import hashlib
import secrets
from pathlib import Path

import msgspec

from engine.processes.private_files import write_private
from engine.protocols.address import TlsAddress
from engine.remote.authority import check_name
from ppaas.clock import Clock, epoch
from ppaas.errors import InvalidInput, NotPermitted

PREFIX = "ppaas-join-"


class Ticket(msgspec.Struct, frozen=True, array_like=True):
    """What the machine is handed.

    Parameters
    ----------
    host, port
        Where the cloud takes machines.
    cloud : str
        SHA-256 of the cloud's certificate, in hexadecimal: the machine tells its secret to no other.
    secret : str
        Shows that the administrator wants the machine to join.
    """

    host: str
    port: int
    cloud: str
    secret: str

    def __str__(self) -> str:
        return PREFIX + base64.urlsafe_b64encode(msgspec.msgpack.encode(self)).decode().rstrip("=")

    @property
    def address(self) -> TlsAddress:
        """Where the cloud takes machines."""
        return TlsAddress(self.host, self.port)


class _TicketFile(msgspec.Struct, frozen=True):
    """What the cloud knows of a ticket: until when it is good, in seconds since the epoch, and for which machine."""

    until: float
    machine: str | None


def read_ticket(text: str) -> Ticket:
    """Read a ticket.

    Raises
    ------
    InvalidInput
        It is none.
    """
    body = text.strip().removeprefix(PREFIX)
    try:
        packed = base64.b64decode(body + "=" * (-len(body) % 4), b"-_", validate=True)
        return msgspec.msgpack.decode(packed, type=Ticket)
    except (ValueError, msgspec.DecodeError) as error:
        raise InvalidInput("this is no ticket: copy all that 'ppaas machine ticket' printed") from error


class Tickets:
    """The tickets of a cloud that were not used yet.

    Parameters
    ----------
    folder : Path
        For a file of each; made if it is not there.
    clock : callable
        Seconds since the epoch.
    """

    def __init__(self, folder: Path, clock: Clock = epoch) -> None:
        self._folder = folder
        self._clock = clock

    def make(self, address: TlsAddress, cloud: str, *, valid: float, machine: str | None = None) -> Ticket:
        """Make a ticket.

        Parameters
        ----------
        address : TlsAddress
            At which the machine reaches the cloud.
        cloud : str
            SHA-256 of the cloud's certificate.
        valid : float
            Seconds for which it is good.
        machine : str, optional
            Name of the machine that it is for, which may have joined before; without it, of any that has not.

        Raises
        ------
        InvalidInput
            No machine may be named so, or the folder cannot be used.
        """
        if machine is not None:
            check_name(machine)
        ticket = Ticket(address.host, address.port, cloud, secrets.token_urlsafe(24))
        try:
            self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            write_private(self._path(ticket.secret), msgspec.json.encode(_TicketFile(self._clock() + valid, machine)))
        except OSError as error:
            raise InvalidInput(f"the ticket cannot be kept: {error}") from error
        return ticket

    def use(self, secret: str, machine: str) -> bool:
        """Use a ticket up; return whether it was made for the machine of that name.

        Raises
        ------
        NotPermitted
            There is no such ticket, or no longer, or it is for another machine.
        """
        path = self._path(secret)
        try:
            kept = msgspec.json.decode(path.read_bytes(), type=_TicketFile)
            if kept.machine not in (None, machine):
                raise NotPermitted(f"this ticket is for machine {kept.machine!r}: join with --name {kept.machine}")
            path.unlink()  # of two that use it at a time one finds it gone
        except FileNotFoundError as error:
            raise NotPermitted("this ticket is not known, or was used: make a new one") from error
        if self._clock() > kept.until:
            raise NotPermitted("this ticket is too old: make a new one")
        return kept.machine is not None

    def _path(self, secret: str) -> Path:
        return self._folder / f"{hashlib.sha256(secret.encode()).hexdigest()}.json"
