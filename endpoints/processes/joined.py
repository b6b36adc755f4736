"""Settings of an endpoint on a joined machine: those of its machine, and those that its cloud tells."""

import asyncio
import logging
import socket
from pathlib import Path
from typing import NamedTuple

from endpoints.processes.config import EndpointConfig, JoinedEndpointConfig
from engine.endpoint.far_master import FarMaster
from engine.endpoint.link_listener import MachineAccess
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.masters import Masters
from engine.remote.membership import Membership, membership_in
from ppaas import __version__
from ppaas.errors import Conflict, Unavailable
from storage.urls.opening import check_exists

logger = logging.getLogger(__name__)

RETRY = 1.0
"""Time between two attempts to reach the cloud [s]."""


class Joined(NamedTuple):
    """Endpoint of a joined machine: its settings, and its access to masters and to containers of other hosts."""

    config: EndpointConfig
    master: FarMaster
    machines: MachineAccess


async def joined(wanted: JoinedEndpointConfig) -> Joined:
    """Return an endpoint's settings once a master that leads has told its own.

    Raises
    ------
    Conflict
        The cloud runs another release.
    InvalidInput, NotFound
        The machine has not joined, or the stores of the cloud cannot be reached from here.
    """
    membership = await asyncio.to_thread(membership_in, Path(wanted.folder))
    settings = await _settings(Masters(membership))
    if settings.release != __version__:
        raise Conflict(
            f"the cloud runs release {settings.release or '(unknown)'}, but endpoint {wanted.name} is of "
            f"{__version__}: install the cloud's release and start the machine again"
        )
    for url in (settings.store, settings.map_store):
        check_exists(url)
    host = wanted.listen or await asyncio.to_thread(_address_towards, membership.cloud.host, membership.cloud.port)
    return Joined(
        _config(wanted, membership, settings),
        FarMaster(membership, settings),
        MachineAccess(host, membership.identity.authority),
    )


async def _settings(masters: Masters) -> ClusterSettings:
    while True:
        try:
            return await masters.settings()
        except Unavailable as error:
            logger.warning("no master is reachable yet: %s", error)
        await asyncio.sleep(RETRY)


def _address_towards(host: str, port: int) -> str:
    """Return the address of this host from which packets to another one are sent; none is sent.

    Raises
    ------
    Unavailable
        The other host is unknown, or there is no way to it.
    """
    try:
        family, kind, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        with socket.socket(family, kind) as probe:
            probe.connect(address)
            return str(probe.getsockname()[0])
    except OSError as error:
        raise Unavailable(f"this host has no way to {host}: {error}; give --listen HOST") from error


def _config(wanted: JoinedEndpointConfig, membership: Membership, settings: ClusterSettings) -> EndpointConfig:
    return EndpointConfig(
        name=wanted.name,
        machine=membership.machine,
        run_dir=wanted.run_dir,
        secret="",  # the certificate identifies the machine
        store=settings.store,
        map_store=settings.map_store,
        outbox=str(membership.folder / "outbox.sqlite"),
        reserve=None,
        recordings=None,
        machines=None,
        listen_machines=None,
        data="",
        keep_versions=settings.serves.keep_versions,
        quota=settings.serves.quota,
        linger=settings.serves.linger,
        holder="",
        orphaned=settings.runs.adopt_within,
        allowed=settings.runs.allowed,
        front=wanted.front,
    )
