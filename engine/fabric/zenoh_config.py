"""How Zenoh is set up: no scouting, no shared memory, nobody without a password, no host without a certificate."""

import json
from collections.abc import Sequence
from typing import Any

import msgspec
import zenoh


class RouterCredentials(msgspec.Struct, frozen=True):
    """By which a client is known to its router."""

    user: str
    password: str


class Peering(msgspec.Struct, frozen=True):
    """How the routers of a cloud's machines reach each other, over mutual TLS.

    Those of other hosts connect to that of the cloud, which hands on what they say to each other.

    Parameters
    ----------
    key, certificate, authority : str
        Files in PEM: what this router shows, and by what it knows the others.
    credentials : RouterCredentials
        Of all routers of the cloud.
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
        By which it names itself to other routers.
    peering : Peering, optional
        How it reaches those of other hosts.
    """
    settings = {
        "mode": "router",
        "listen/endpoints": [*listen, *(peering.listen if peering else ())],
        "scouting/delay": 0,  # there is nobody to wait for
        "transport/auth/usrpwd/dictionary_file": dictionary,
    }
    return _config(settings | (_between_hosts(peering) if peering else {}), own)


def _between_hosts(peering: Peering) -> dict[str, Any]:
    return {
        "connect/endpoints": list(peering.connect),
        "connect/timeout_ms": -1,  # the other router may come later, and come back
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": 100, "period_max_ms": 1000, "period_increase_factor": 2},
        "transport/link/tls": {
            "root_ca_certificate": peering.authority,
            "enable_mtls": True,
            "listen_private_key": peering.key,
            "listen_certificate": peering.certificate,
            "connect_private_key": peering.key,
            "connect_certificate": peering.certificate,
            # Of our authority's certificates the cloud's alone is good for a server, whatever its host is called.
            "verify_name_on_connect": False,
        },
    }


def client_config(endpoint: str, credentials: RouterCredentials) -> zenoh.Config:
    """Return the configuration of a client that comes back soon after its router does."""
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
        "transport/link/tx/lease": 2000,  # ms of silence after which a frozen peer is cut off
        "transport/link/tx/queue/size/data": 16,  # batches, the most there may be; a burst fills fewer in no time
        "transport/auth/usrpwd/user": credentials.user,
        "transport/auth/usrpwd/password": credentials.password,
    }
    config = zenoh.Config()
    for path, value in (common | settings).items():
        config.insert_json5(path, json.dumps(value))
    return config
