"""The cloud's side of remote machines: its certificate authority, its tickets, and the port that they connect to."""

import asyncio
import secrets
import socket
from pathlib import Path

import msgspec

from engine.fabric.zenoh_config import Peering, RouterCredentials
from engine.processes.private_files import write_private
from engine.protocols.address import EVERYWHERE, TlsAddress, parse_address
from engine.protocols.control_link import MastersChanged
from engine.protocols.framing import FrameStream
from engine.remote.authority import Authority
from engine.remote.cluster_settings import ClusterSettings, ContainerSettings, EndpointSettings
from engine.remote.joining import JoinServer
from engine.remote.known_masters import KnownMasters
from engine.remote.standbys import Standbys
from engine.remote.tickets import Ticket, Tickets
from engine.remote.tls_listener import FromMachine, TlsListener
from engine.service.links.control_server import ControlServer
from engine.service.links.robot_link_server import LinkServer
from ppaas import __version__
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, Unavailable

ADDRESS = "address"
"""File with the address for machines; it exists while the cloud listens there."""

FABRIC = "fabric.json"
"""File with the credentials of the cloud's routers, so that routers of machines reconnect to a restarted cloud."""


class RemoteMachines:
    """Accepts machines of other hosts.

    Parameters
    ----------
    folder : Path
        Folder of certificates and tickets, in the data folder of the cloud.
    address : TlsAddress
        Address to listen at. The router listens at the next port, or at any free one if the port is 0.
    cloud : str
        Instance name of the cloud process.
    store, map_store : str
        URLs of the stores.
    own : str
        Name of the local machine.
    runs : ContainerSettings
        Settings of containers.
    serves : EndpointSettings
        Settings of endpoints.

    Raises
    ------
    InvalidInput
        The folder cannot be used, or other hosts cannot reach the stores.
    Unavailable
        The address does not belong to this host.
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
        serves: EndpointSettings = EndpointSettings(),  # noqa: B008 - it is frozen
    ) -> None:
        for url in (store, map_store):
            check_reachable(url)
        self._folder = folder
        self._authority = Authority(folder)
        self._address = address
        self._masters = KnownMasters(folder)
        self._standbys = Standbys(folder.parent, self._masters, self._announce)
        self._join_server = JoinServer(self._authority, Tickets(folder / "tickets"), frozenset((own,)))
        router = address._replace(port=address.port + 1 if address.port else _free_port(address.host))
        credentials = _credentials(folder / FABRIC)
        self._settings = ClusterSettings(
            cloud, store, map_store, router.port, credentials, runs, __version__, serves=serves
        )
        identity = self._authority.identity
        self.peering = Peering(
            str(identity.key), str(identity.certificate), str(identity.authority), credentials,
            listen=(f"tls/{router.authority}",),
        )  # fmt: skip
        self._listener: TlsListener | None = None
        self._control: ControlServer | None = None

    @property
    def host(self) -> str | None:
        """Host name or address of the cloud for machines, or None if it listens at all addresses."""
        return None if self._address.host in EVERYWHERE else self._address.host

    async def start(self, control: ControlServer, robots: LinkServer, endpoints: FromMachine) -> None:
        """Listen, and write the address to a file, for tickets.

        Raises
        ------
        Unavailable
            The address is in use, or does not belong to this host.
        """
        self._control, self._standbys.mandate = control, control.mandate
        self._listener = TlsListener(
            self._address,
            self._authority,
            control=control.connected,
            robot=robots.connected,
            settings=self._send_settings,
            standby=self._standbys.connected,
            endpoint=endpoints,
            join=self._join_server.connected,
        )
        await self._listener.start()
        write_private(self._folder / ADDRESS, str(self._listener.address).encode())

    async def _send_settings(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, machine: str) -> None:
        """Send the settings of the cluster; without a mandate, close the connection: another master may lead."""
        stream: FrameStream[ClusterSettings] = FrameStream(reader, writer, ClusterSettings)
        mandate = self._standbys.mandate
        if mandate.leads():
            settings = msgspec.structs.replace(self._settings, epoch=mandate.epoch, masters=self._masters.texts())
            await stream.send(settings)
        await stream.close()

    def _announce(self) -> None:
        """Send all machines the addresses of the cloud's masters."""
        if self._control is not None:
            self._control.tell_all(MastersChanged(self._masters.texts()))

    async def close(self) -> None:
        """Close all connections and stop listening."""
        if self._listener is not None:
            (self._folder / ADDRESS).unlink(missing_ok=True)
            await self._listener.close()


def _credentials(file: Path) -> RouterCredentials:
    try:
        if not file.exists():
            write_private(file, msgspec.json.encode(RouterCredentials("agent", secrets.token_urlsafe(32))))
        return from_json(file.read_bytes(), RouterCredentials)
    except (OSError, msgspec.DecodeError) as error:
        raise InvalidInput(
            f"the credentials of routers in {file} cannot be read; repair or remove the file: {error}"
        ) from error


def check_reachable(url: str) -> None:
    """Check that machines of other hosts can reach a store.

    Raises
    ------
    InvalidInput
        The store is in the memory of one process.
    """
    if url.startswith("memory:"):
        raise InvalidInput(
            "machines of other hosts cannot reach a store in memory: set --store and --map-store to shared ones, "
            "such as cassandra: and hdfs:, or to a folder that all hosts share"
        )


def make_ticket(folder: Path, *, valid: float, machine: str | None = None, host: str | None = None) -> Ticket:
    """Make a ticket for a running cloud.

    Parameters
    ----------
    folder : Path
        Folder of the cloud's certificates and tickets.
    valid : float
        Time for which the ticket is valid [s].
    machine : str, optional
        Name of the machine that may use it. Default: any new machine.
    host : str, optional
        Host name or address by which the machine reaches this host. Default: the address that the cloud listens at, or
        the name of this host.

    Raises
    ------
    Unavailable
        No cloud that accepts machines runs with this folder.
    InvalidInput
        The name of the machine is invalid.
    """
    try:
        address = parse_address((folder / ADDRESS).read_text())
    except OSError as error:
        raise Unavailable(
            f"no cloud that accepts machines of other hosts runs with the folder {folder}: start it with "
            "'ppaas up --listen-machines HOST:PORT', or name its data folder by --data"
        ) from error
    if not isinstance(address, TlsAddress):
        raise Unavailable(f"{folder / ADDRESS} has no address for machines; restart the cloud")
    reached = host or (socket.gethostname() if address.host in EVERYWHERE else address.host)
    cloud = Authority(folder).fingerprint
    return Tickets(folder / "tickets").make(address._replace(host=reached), cloud, valid=valid, machine=machine)


def _free_port(host: str) -> int:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.create_server((host, 0), family=family) as listener:
            return int(listener.getsockname()[1])
    except OSError as error:
        raise Unavailable(
            f"cannot listen at {host} for machines: {error.strerror}; use an address of this host"
        ) from error
