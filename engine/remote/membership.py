"""Membership of a machine of another host: its files about the cloud that it has joined."""

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
from engine.remote.authority import Authority, Key, check_name, key_pem, new_key, request_pem
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.joining import Joined, read_ticket, request_certificate
from engine.remote.secret_joining import join_masters
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, NotFound, Unavailable

FILE = "membership.json"


class _MembershipFile(msgspec.Struct, frozen=True):
    machine: str
    host: str
    port: int
    ticket: str


@dataclass(frozen=True, slots=True)
class Membership:
    """A machine and the cloud that it has joined.

    Parameters
    ----------
    folder : Path
        Folder of the machine's key and certificates.
    machine : str
        Name of the machine.
    cloud : TlsAddress
        Address of the cloud for machines.
    """

    folder: Path
    machine: str
    cloud: TlsAddress

    @property
    def identity(self) -> TlsIdentity:
        """Key and certificates of the machine."""
        return TlsIdentity.in_folder(self.folder, "machine")

    @property
    def outbox(self) -> Path:
        """File that queues plans of the machine while a store is unavailable."""
        return self.folder / "outbox.sqlite"

    async def settings(self, master: TlsAddress | None = None) -> ClusterSettings:
        """Request the settings of the cluster from a master, by default the one that this machine has joined.

        Raises
        ------
        Unavailable
            The master is unreachable, does not lead, or refuses this machine.
        """
        address = master or self.cloud
        stream: FrameStream[ClusterSettings] = FrameStream(
            *await dial(address, self.identity.client_context("terms")), ClusterSettings
        )
        try:
            settings = await stream.receive()
        finally:
            await stream.close()
        if settings is None:
            raise Unavailable(
                f"the cloud at {address} closed the connection; if it logs that the certificate of {self.machine!r} "
                "is no longer valid, join again with a new ticket"
            )
        return settings

    def peering(self, settings: ClusterSettings, routers: tuple[str, ...] = ()) -> Peering:
        """Return the connection of the machine's router to ``routers``, by default to the cloud's router."""
        identity, router = self.identity, self.cloud._replace(port=settings.fabric_port)
        return Peering(
            str(identity.key), str(identity.certificate), str(identity.authority), settings.fabric,
            connect=routers or (f"tls/{router.authority}",),
        )  # fmt: skip


def membership_in(folder: Path) -> Membership:
    """Read the membership in a folder.

    Raises
    ------
    NotFound
        The machine has not joined a cloud.
    InvalidInput
        The file cannot be read.
    """
    known = _read(folder)
    if known is None:
        raise NotFound("cloud of this machine (join with a ticket first)", str(folder))
    return Membership(folder, known.machine, TlsAddress(known.host, known.port))


async def join_by_secret(folder: Path, file: Path, machine: str, masters: tuple[TlsAddress, ...]) -> Membership:
    """Join with a secret. Does nothing if this machine has joined under the same name before.

    Parameters
    ----------
    folder : Path
        Folder of the machine's key and certificates; created, private to this user, if it does not exist.
    file : Path
        File of join secrets.
    machine : str
        Name of the machine.
    masters : tuple of TlsAddress
        Addresses at which a master of the cloud may listen for machines.

    Raises
    ------
    InvalidInput
        The name or the secrets are invalid, or the folder cannot be used.
    PPaaSError
        The error of ``join_masters``.
    """
    check_name(machine)
    known = _read(folder)
    if known is None or known.machine != machine:
        key = new_key()
        joined, cloud = await join_masters(masters, file, machine, request_pem(key, machine))
        _write(folder, key, joined, _MembershipFile(machine, cloud.host, cloud.port, ""))
    return membership_in(folder)


async def join(folder: Path, text: str, machine: str) -> Membership:
    """Join with a ticket. Does nothing if this machine has joined with the same ticket before.

    Parameters
    ----------
    folder : Path
        Folder of the machine's key and certificates; created, private to this user, if it does not exist.
    text : str
        The ticket.
    machine : str
        Name of the machine.

    Raises
    ------
    InvalidInput
        The ticket or the name is invalid, or the folder cannot be used.
    PPaaSError
        The error of ``request_certificate``.
    """
    ticket, used = read_ticket(text), hashlib.sha256(text.strip().encode()).hexdigest()
    check_name(machine)
    known = _read(folder)
    if known is None or known.ticket != used:
        key = new_key()
        joined = await request_certificate(ticket, machine, request_pem(key, machine))
        _write(folder, key, joined, _MembershipFile(machine, ticket.host, ticket.port, used))
    return membership_in(folder)


def enrol(folder: Path, authority: Authority, name: str, cloud: TlsAddress) -> Membership:
    """Join with a certificate of an authority whose key is here.

    Raises
    ------
    InvalidInput
        The name is invalid, or the folder cannot be used.
    """
    key = new_key()
    joined = Joined(authority.issue(name, request_pem(key, name)), authority.pem)
    _write(folder, key, joined, _MembershipFile(name, cloud.host, cloud.port, ""))
    return membership_in(folder)


def _write(folder: Path, key: Key, joined: Joined, membership: _MembershipFile) -> None:
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        identity = TlsIdentity.in_folder(folder, "machine")
        write_private(identity.key, key_pem(key))
        write_private(identity.certificate, joined.certificate)
        write_private(identity.authority, joined.authority)
        write_private(folder / FILE, msgspec.json.encode(membership))
    except OSError as error:
        raise InvalidInput(f"the certificate cannot be stored in {folder}: {error}") from error


def _read(folder: Path) -> _MembershipFile | None:
    path = folder / FILE
    try:
        return from_json(path.read_bytes(), _MembershipFile) if path.exists() else None
    except (OSError, msgspec.DecodeError) as error:
        raise InvalidInput(f"{path} cannot be read: {error}; remove the folder and join with a new ticket") from error
