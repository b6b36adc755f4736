"""How Zenoh is set up: no scouting, no shared memory, nobody without a password."""

import json
from collections.abc import Sequence
from typing import Any

import msgspec
import zenoh


class Credentials(msgspec.Struct, frozen=True):
    """By which a client is known to its router."""

    user: str
    password: str


def router_config(listen: Sequence[str], dictionary: str, own: Credentials) -> zenoh.Config:
    """Return the configuration of a router.

    Parameters
    ----------
    listen : sequence of str
        Zenoh endpoints.
    dictionary : str
        File with a line ``name:password`` for each client.
    own : Credentials
        By which it names itself to other routers.
    """
    return _config(
        {
            "mode": "router",
            "listen/endpoints": list(listen),
            "scouting/delay": 0,  # there is nobody to wait for
            "transport/auth/usrpwd/dictionary_file": dictionary,
        },
        own,
    )


def client_config(endpoint: str, credentials: Credentials) -> zenoh.Config:
    """Return the configuration of a client that comes back soon after its router does."""
    return _config(
        {
            "mode": "client",
            "connect/endpoints": [endpoint],
            "connect/retry": {"period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 2},
        },
        credentials,
    )


def _config(settings: dict[str, Any], credentials: Credentials) -> zenoh.Config:
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
