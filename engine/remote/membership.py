"""What a machine of another host keeps of the cloud that it has joined."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

import msgspec

from engine.fabric.zenoh_config import Peering
from engine.processes.private_files import write_private
from engine.protocols.address import TlsAddress
from engine.protocols.framing import FrameStream
from engine.protocols.sockets import dial
from engine.protocols.tls_identity import TlsIdentity
from engine.remote.authority import check_name
from engine.remote.certificates import Key, key_pem, new_key, request_pem
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.joining import Joined, ask_to_join
from engine.remote.tickets import read_ticket
from ppaas.errors import InvalidInput, NotFound, Unavailable

FILE = "membership.json"


class _MembershipFile(msgspec.Struct, frozen=True):
    machine: str
    host: str
    port: int
    ticket: str


@dataclass(frozen=True, slots=True)
class Membership:
    """A machine and its cloud.

    Parameters
    ----------
    folder : Path
        With the machine's key and certificates.
    machine : str
        Its name.
    cloud : TlsAddress
        Where the cloud takes it.
    """

    folder: Path
    machine: str
    cloud: TlsAddress

    @property
    def identity(self) -> TlsIdentity:
        """Return the machine's key and certificates."""
        return TlsIdentity.in_folder(self.folder, "machine")

    async def settings(self) -> ClusterSettings:
        """Ask the cloud what the machine must know to register.

        Raises
        ------
        Unavailable
            The cloud is away, or hangs up on this machine.
        """
        stream: FrameStream[ClusterSettings] = FrameStream(
            *await dial(self.cloud, self.identity.client_context("terms")), ClusterSettings
        )
        try:
            told = await stream.receive()
        finally:
            await stream.close()
        if told is None:
            raise Unavailable(
                f"the cloud at {self.cloud} hung up; if it logs that the certificate of {self.machine!r} is good no "
                "more, join by a new ticket"
            )
        return told

    def peering(self, terms: ClusterSettings) -> Peering:
        """Return how the machine's router reaches that of the cloud."""
        identity, router = self.identity, self.cloud._replace(port=terms.fabric_port)
        return Peering(
            str(identity.key), str(identity.certificate), str(identity.authority), terms.fabric,
            connect=(f"tls/{router.authority}",),
        )  # fmt: skip


def membership_in(folder: Path) -> Membership:
    """Read what is kept.

    Raises
    ------
    NotFound
        Nothing is: the machine has joined no cloud.
    InvalidInput
        It cannot be read.
    """
    kept = _kept_in(folder)
    if kept is None:
        raise NotFound("cloud of this machine (join by a ticket first)", str(folder))
    return Membership(folder, kept.machine, TlsAddress(kept.host, kept.port))


async def join(folder: Path, text: str, machine: str) -> Membership:
    """Join by a ticket; by the one that this machine joined with, nothing is to be done.

    Parameters
    ----------
    folder : Path
        For the machine's key and certificates; made, readable by this user alone, if it is not there.
    text : str
        The ticket.
    machine : str
        Name that the machine wants.

    Raises
    ------
    InvalidInput
        It is no ticket, no name, or the folder cannot be used.
    PPaaSError
        What the cloud says.
    """
    ticket, used = read_ticket(text), hashlib.sha256(text.strip().encode()).hexdigest()
    check_name(machine)
    kept = _kept_in(folder)
    if kept is None or kept.ticket != used:
        key = new_key()
        joined = await ask_to_join(ticket, machine, request_pem(key, machine))
        _keep(folder, key, joined, _MembershipFile(machine, ticket.host, ticket.port, used))
    return membership_in(folder)


def _keep(folder: Path, key: Key, joined: Joined, membership: _MembershipFile) -> None:
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        identity = TlsIdentity.in_folder(folder, "machine")
        write_private(identity.key, key_pem(key))
        write_private(identity.certificate, joined.certificate)
        write_private(identity.authority, joined.authority)
        write_private(folder / FILE, msgspec.json.encode(membership))
    except OSError as error:
        raise InvalidInput(f"what the cloud gave cannot be kept: {error}") from error


def _kept_in(folder: Path) -> _MembershipFile | None:
    path = folder / FILE
    try:
        return msgspec.json.decode(path.read_bytes(), type=_MembershipFile) if path.exists() else None
    except (OSError, msgspec.DecodeError) as error:
        raise InvalidInput(f"{path} cannot be read: {error}; remove the folder and join by a new ticket") from error
