"""Configuration of Zenoh: no scouting, no shared memory; passwords for clients, certificates for hosts."""

import json
from collections.abc import Sequence
from typing import Any

import msgspec
import zenoh


class RouterCredentials(msgspec.Struct, frozen=True):
    """Name and password of a client of a router."""

    user: str
    password: str


class Peering(msgspec.Struct, frozen=True):
    """Connections between the routers of a cloud's machines, over mutual TLS.

    The routers of other hosts connect to the cloud's router, which forwards messages between them.

    Parameters
    ----------
    key, certificate, authority : str
        PEM files: key and certificate of this router, and the certificate of the authority that signed the others'.
    credentials : RouterCredentials
        Credentials that all routers of the cloud share.
    listen, connect : tuple of str
        Zenoh endpoints, ``tls/host:port``.
    """

    key: str
    certificate: str
    authority: str
    credentials: RouterCredentials
    listen: tuple[str, ...] = ()
    connect: tuple[str, ...] = ()


def router_config(
    listen: Sequence[str], dictionary: str, own: RouterCredentials, peering: Peering | None = None
) -> zenoh.Config:
    """Return the configuration of a router.

    Parameters
    ----------
    listen : sequence of str
        Zenoh endpoints.
    dictionary : str
        File with a line ``name:password`` for each client.
    own : RouterCredentials
        Credentials of this router for other routers.
    peering : Peering, optional
        Connection to the routers of other hosts.
    """
    settings = {
        "mode": "router",
        "listen/endpoints": [*listen, *(peering.listen if peering else ())],
        "scouting/delay": 0,  # no scouting, so nothing to wait for
        "transport/auth/usrpwd/dictionary_file": dictionary,
    }
    return _config(settings | (_between_hosts(peering) if peering else {}), own)


def _between_hosts(peering: Peering) -> dict[str, Any]:
    return {
        "connect/endpoints": list(peering.connect),
        "connect/timeout_ms": -1,  # never give up: the other router may start later, or restart
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": 100, "period_max_ms": 1000, "period_increase_factor": 2},
        "transport/link/tls": {
            "root_ca_certificate": peering.authority,
            "enable_mtls": True,
            "listen_private_key": peering.key,
            "listen_certificate": peering.certificate,
            "connect_private_key": peering.key,
            "connect_certificate": peering.certificate,
            # Our authority signs only one server certificate, the cloud's, and it does not name a host.
            "verify_name_on_connect": False,
        },
    }


def client_config(endpoint: str, credentials: RouterCredentials) -> zenoh.Config:
    """Return the configuration of a client that reconnects soon after its router is back."""
    return _config(
        {
            "mode": "client",
            "connect/endpoints": [endpoint],
            "connect/retry": {"period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 2},
        },
        credentials,
    )


def _config(settings: dict[str, Any], credentials: RouterCredentials) -> zenoh.Config:
    common = {
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
        "transport/link/tx/lease": 2000,  # ms of silence after which a frozen peer is disconnected
        "transport/link/tx/queue/size/data": 16,  # batches, the maximum; a burst overruns a shorter queue
        "transport/auth/usrpwd/user": credentials.user,
        "transport/auth/usrpwd/password": credentials.password,
    }
    config = zenoh.Config()
    for path, value in (common | settings).items():
        config.insert_json5(path, json.dumps(value))
    return config
