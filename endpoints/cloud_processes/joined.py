"""Settings of an endpoint on a joined machine: its machine's own, and the ones that its cloud sends."""

import asyncio
import logging
import socket
from pathlib import Path
from typing import NamedTuple

import msgspec

from endpoints.cloud_processes.config import EndpointConfig, FrontConfig, JoinedEndpointConfig
from endpoints.listeners import url_at
from engine.cloud_client.far_master import FarMaster
from engine.cloud_client.link_listener import MachineAccess
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.masters import Masters
from engine.remote.membership import Membership, membership_in
from engine.remote.settings_check import check_settings
from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

RETRY = 1.0
"""Time between two attempts to reach the cloud [s]."""


class JoinedEndpoint(NamedTuple):
    """Endpoint of a joined machine: its settings, and its access to masters and to containers of other hosts."""

    config: EndpointConfig
    master: FarMaster
    machines: MachineAccess


async def joined(wanted: JoinedEndpointConfig) -> JoinedEndpoint:
    """Return an endpoint's settings once a master that leads has told its own.

    Raises
    ------
    Conflict, InvalidInput, NotFound
        The machine has not joined, or as of ``check_settings``.
    Unavailable
        This host has no way to the cloud.
    """
    membership = await asyncio.to_thread(membership_in, Path(wanted.folder))
    masters = Masters(membership)
    settings = await _settings(masters)
    check_settings(settings)
    host = wanted.listen or await asyncio.to_thread(_address_towards, membership.cloud.host, membership.cloud.port)
    return JoinedEndpoint(
        _config(wanted, membership, settings),
        FarMaster(membership, masters, settings),
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


def _url(front: FrontConfig) -> str:
    return url_at(front.host, front.port, "https" if front.tls_cert else "http")


def _config(wanted: JoinedEndpointConfig, membership: Membership, settings: ClusterSettings) -> EndpointConfig:
    return EndpointConfig(
        name=wanted.name,
        machine=membership.machine,
        run_dir=wanted.run_dir,
        secret="",  # the certificate identifies the machine
        store=settings.store,
        map_store=settings.map_store,
        outbox=str(membership.outbox),
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
        front=msgspec.structs.replace(wanted.front, url=_url(wanted.front)),
    )
