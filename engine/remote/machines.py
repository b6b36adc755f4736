"""The cloud's side of machines on other hosts: its authority, its tickets, and the port at which they arrive."""

import asyncio
import secrets
import socket
from pathlib import Path

import msgspec

from engine.fabric.zenoh_config import Peering, RouterCredentials
from engine.processes.private_files import write_private
from engine.protocols.address import TlsAddress, parse_address
from engine.protocols.framing import FrameStream
from engine.remote.authority import Authority
from engine.remote.cluster_settings import ClusterSettings, ContainerSettings
from engine.remote.joining import JoinServer
from engine.remote.tickets import Ticket, Tickets
from engine.remote.tls_listener import TlsListener
from engine.service.links.control_server import ControlServer
from engine.service.links.robot_link_server import LinkServer
from ppaas import __version__
from ppaas.errors import InvalidInput, NotFound, Unavailable

ADDRESS = "address"
"""File that says where the cloud takes machines, while it does."""

FABRIC = "fabric.json"
"""File with what the cloud's routers know each other by: those of machines go on when the cloud is started anew."""

EVERYWHERE = ("0.0.0.0", "::")


class RemoteMachines:
    """Takes machines of other hosts.

    Parameters
    ----------
    folder : Path
        For certificates and tickets, kept with the cloud.
    address : TlsAddress
        Where to listen. The router listens at the next port, or at any where any was to be taken.
    cloud : str
        Name of the cloud process.
    store, map_store : str
        URLs of the stores.
    own : str
        Name of the cloud's own machine.
    runs : ContainerSettings
        How containers run.

    Raises
    ------
    InvalidInput
        The folder cannot be used, or another host cannot reach the stores.
    Unavailable
        The address is not ours.
    """

    def __init__(
        self,
        folder: Path,
        address: TlsAddress,
        *,
        cloud: str,
        store: str,
        map_store: str,
        own: str,
        runs: ContainerSettings = ContainerSettings(),  # noqa: B008 - it is frozen
    ) -> None:
        for url in (store, map_store):
            check_reachable(url)
        self._folder = folder
        self._authority = Authority(folder)
        self._address = address
        self._desk = JoinServer(self._authority, Tickets(folder / "tickets"), frozenset((own,)))
        router = address._replace(port=address.port + 1 if address.port else _free_port(address.host))
        credentials = _credentials(folder / FABRIC)
        self._terms = ClusterSettings(cloud, store, map_store, router.port, credentials, runs, __version__)
        identity = self._authority.identity
        self.peering = Peering(
            str(identity.key), str(identity.certificate), str(identity.authority), credentials,
            listen=(f"tls/{router.authority}",),
        )  # fmt: skip
        self._door: TlsListener | None = None

    @property
    def host(self) -> str | None:
        """By which machines reach the cloud, where it listens at one address alone."""
        return None if self._address.host in EVERYWHERE else self._address.host

    async def start(self, control: ControlServer, robots: LinkServer) -> None:
        """Listen, and say where, for those who make tickets.

        Raises
        ------
        Unavailable
            The address is not ours, or taken.
        """
        self._door = TlsListener(
            self._address,
            self._authority,
            control=control.connected,
            robot=robots.connected,
            terms=self._tell_terms,
            join=self._desk.connected,
        )
        await self._door.start()
        write_private(self._folder / ADDRESS, str(self._door.address).encode())

    async def _tell_terms(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, machine: str) -> None:
        stream: FrameStream[ClusterSettings] = FrameStream(reader, writer, ClusterSettings)
        await stream.send(self._terms)
        await stream.close()

    async def close(self) -> None:
        """Hang up on all, and listen no more."""
        if self._door is not None:
            (self._folder / ADDRESS).unlink(missing_ok=True)
            await self._door.close()


def _credentials(file: Path) -> RouterCredentials:
    try:
        if not file.exists():
            write_private(file, msgspec.json.encode(RouterCredentials("agent", secrets.token_urlsafe(32))))
        return msgspec.json.decode(file.read_bytes(), type=RouterCredentials)
    except (OSError, msgspec.DecodeError) as error:
        raise InvalidInput(f"{file} is not what was kept for routers: mend it, or remove it: {error}") from error


def check_reachable(url: str) -> None:
    """Make sure that a store can be one of a cloud with machines on other hosts.

    Raises
    ------
    InvalidInput
        It is in the memory of one process.
    """
    if url.startswith("memory:"):
        raise InvalidInput(
            "machines of other hosts cannot reach a store in memory: give --store and --map-store that they can, "
            "as cassandra: and hdfs:, or a folder that all hosts share"
        )


def make_ticket(folder: Path, *, valid: float, machine: str | None = None, host: str | None = None) -> Ticket:
    """Make a ticket for a cloud that runs.

    Parameters
    ----------
    folder : Path
        Of its certificates and tickets.
    valid : float
        Seconds for which it is good.
    machine : str, optional
        Name of the machine that it is for; without it, of any new one.
    host : str, optional
        By which the machine reaches this host; without it, as the cloud listens, or by the name of this host.

    Raises
    ------
    NotFound
        No cloud that takes machines runs with this folder.
    InvalidInput
        No machine may be named so.
    """
    try:
        address = parse_address((folder / ADDRESS).read_text())
    except OSError as error:
        raise NotFound("cloud that takes machines (start it with --listen-machines)", str(folder)) from error
    if not isinstance(address, TlsAddress):
        raise Unavailable(f"{folder / ADDRESS} does not say where the cloud takes machines; start the cloud anew")
    reached = host or (socket.gethostname() if address.host in EVERYWHERE else address.host)
    cloud = Authority(folder).fingerprint
    return Tickets(folder / "tickets").make(address._replace(host=reached), cloud, valid=valid, machine=machine)


def _free_port(host: str) -> int:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.create_server((host, 0), family=family) as listener:
            return int(listener.getsockname()[1])
    except OSError as error:
        raise Unavailable(f"cannot listen at {host} for machines: {error.strerror}; give an address of ours") from error
