"""Settings of an endpoint process, which its keeper passes on standard input."""

import argparse
from typing import Any

import msgspec

from endpoints.oidc.settings import OidcSettings, provider_settings
from endpoints.settings.live import LiveSettings
from engine.master.quotas import Quota


class FrontConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Settings with which an endpoint serves clients; the options of ``ppaas up`` and ``ppaas machine join``.

    Parameters
    ----------
    host : str
        Address to listen at.
    port : int
        Port of REST and of robots; other endpoints of this host may have the same.
    rapyuta, foxglove : int, optional
        Ports of robots of Rapyuta, and of viewers of Foxglove.
    url : str
        Address at which it serves clients, for lists; empty on a joined machine until its endpoint knows the host.
    advertised : str
        Address sent to robots whose container is on this machine; empty for none.
    dead : float
        Time after which a silent connection counts as dead [s].
    log_level, root_path : str
        As the options.
    tls_cert, tls_key : str
        Files of certificate and key; empty for none.
    trusted_proxy, allow_origin : tuple of str
        As the options.
    docs_site : str
        Folder of the documentation site; empty for that of a checkout.
    max_connections, max_connections_per_address : int, optional
        Limits of connections of this process.
    oidc : OidcSettings, optional
        Login with an identity provider; None if the cloud has none.
    """

    host: str
    port: int
    rapyuta: int | None = None
    foxglove: int | None = None
    url: str = ""
    advertised: str
    dead: float
    log_level: str
    root_path: str
    tls_cert: str
    tls_key: str
    trusted_proxy: tuple[str, ...]
    allow_origin: tuple[str, ...]
    docs_site: str = ""
    max_connections: int | None
    max_connections_per_address: int | None
    oidc: OidcSettings | None = None


def front_config(
    arguments: argparse.Namespace, *, port: int, url: str = "", rapyuta: int | None = None, foxglove: int | None = None
) -> FrontConfig:
    """Return the settings from the options that ``endpoints.cli.front_options`` adds."""
    return FrontConfig(
        host=arguments.host,
        port=port,
        rapyuta=rapyuta,
        foxglove=foxglove,
        url=url,
        advertised=arguments.advertise,
        dead=arguments.dead,
        log_level=arguments.log_level,
        root_path=arguments.root_path,
        tls_cert=str(arguments.tls_cert.resolve()) if arguments.tls_cert else "",
        tls_key=str(arguments.tls_key.resolve()) if arguments.tls_key else "",
        trusted_proxy=tuple(arguments.trusted_proxy),
        allow_origin=tuple(arguments.allow_origin),
        docs_site=str(arguments.docs_site.resolve()) if arguments.docs_site else "",
        max_connections=arguments.max_connections,
        max_connections_per_address=arguments.max_connections_per_address,
        oidc=provider_settings(arguments),
    )


class EndpointConfig(msgspec.Struct, frozen=True, kw_only=True, tag="own"):
    """Settings of an endpoint process on the host of its master.

    Parameters
    ----------
    name : str
        Name of the endpoint, unique in the cloud.
    machine : str
        Machine on which it runs.
    run_dir : str
        Folder of the sockets of the cloud; the master's and the endpoints' sockets are in it.
    secret : str
        Secret of the cloud's own processes.
    store, map_store : str
        URLs of the stores.
    outbox, reserve, recordings : str, optional
        As in ``engine.bootstrap.CloudConfig``.
    machines, listen_machines : str, optional
        Folder of the cloud's certificates, and address for machines of other hosts; None for none.
    data : str
        Folder of the audit log.
    keep_versions : int, optional
        Number of versions of a map that are kept; None for all.
    quota : Quota
        Quota of users without own limits.
    linger : float
        Time for which the place of a robot outlives its last client [s].
    holder : str
        Name under which the master of this data folder holds the lease.
    orphaned : float
        Time without a master after which the process ends [s].
    allowed : tuple of str
        As the option of ``ppaas up``.
    front : FrontConfig
    """

    name: str
    machine: str
    run_dir: str
    secret: str
    store: str
    map_store: str
    outbox: str | None
    reserve: str | None
    recordings: str | None
    machines: str | None
    listen_machines: str | None
    data: str
    keep_versions: int | None
    quota: Quota
    linger: float
    holder: str
    orphaned: float
    allowed: tuple[str, ...]
    front: FrontConfig


OF_FRONT = tuple(name for name in LiveSettings.__struct_fields__ if name in FrontConfig.__struct_fields__)
"""Settings that an endpoint follows and that its front has, under the same names."""


def settings_at_start(config: EndpointConfig) -> LiveSettings:
    """Return what an endpoint follows, as it is when it starts."""
    of_front: dict[str, Any] = {name: getattr(config.front, name) for name in OF_FRONT}
    return LiveSettings(quota=config.quota, keep_versions=config.keep_versions, **of_front)


def with_settings(config: EndpointConfig, live: LiveSettings) -> EndpointConfig:
    """Return the settings with which an endpoint starts as one that follows ``live``."""
    front = msgspec.structs.replace(config.front, **{name: getattr(live, name) for name in OF_FRONT})
    return msgspec.structs.replace(config, quota=live.quota, keep_versions=live.keep_versions, front=front)


class JoinedEndpointConfig(msgspec.Struct, frozen=True, kw_only=True, tag="joined"):
    """Settings of an endpoint process on a machine that has joined; it requests the others from its cloud.

    Parameters
    ----------
    name : str
        Name of the endpoint, unique in the cloud.
    run_dir : str
        Folder for its sockets.
    folder : str
        Folder of the machine's membership.
    listen : str
        Host or address at which containers of other hosts reach it; empty for the one that reaches the cloud.
    front : FrontConfig
    """

    name: str
    run_dir: str
    folder: str
    listen: str
    front: FrontConfig


Config = EndpointConfig | JoinedEndpointConfig
