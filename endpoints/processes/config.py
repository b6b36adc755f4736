"""Settings of an endpoint process, which its keeper passes on standard input."""

import msgspec

from engine.master.quotas import Quota


class EndpointConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Settings of an endpoint process.

    Parameters
    ----------
    name : str
        Name of the endpoint, unique in the cloud.
    machine : str
        Machine on which it runs.
    url : str
        Address at which clients reach it.
    run_dir : str
        Folder of the sockets of the cloud; the master's and those of endpoints are in it.
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
    host : str
        Address to listen at.
    port : int
        Port of REST and of robots; other endpoints of this host may have the same.
    rapyuta, foxglove : int, optional
        Ports of robots of Rapyuta, and of viewers of Foxglove.
    linger, dead : float
        As the options of ``ppaas up`` [s].
    holder : str
        Name under which the master of this data folder holds the lease.
    orphaned : float
        Time without a master after which the process ends [s].
    log_level : str
        As the options of ``ppaas up``.
    root_path, tls_cert, tls_key : str
        As the options of ``ppaas up``; empty for none.
    trusted_proxy, allow_origin, allowed : tuple of str
        As the options of ``ppaas up``.
    max_connections, max_connections_per_address : int, optional
        Limits of connections of this process.
    """

    name: str
    machine: str
    url: str
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
    host: str
    port: int
    rapyuta: int | None
    foxglove: int | None
    linger: float
    dead: float
    holder: str
    orphaned: float
    log_level: str
    root_path: str
    trusted_proxy: tuple[str, ...]
    allow_origin: tuple[str, ...]
    tls_cert: str
    tls_key: str
    max_connections: int | None
    max_connections_per_address: int | None
    allowed: tuple[str, ...]
