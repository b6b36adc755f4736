"""Addresses of endpoints for containers, and the names of the sockets between both."""

import re
from pathlib import Path

import msgspec

RELAY = "relay.sock"
"""Name of the socket of a machine that relays to endpoints which its containers cannot dial."""

_ENDPOINT = re.compile(r"endpoint-[\w.-]+\.sock")


class EndpointAddress(msgspec.Struct, frozen=True):
    """Addresses of an endpoint for containers.

    Parameters
    ----------
    machine : str
        Machine on which it runs.
    near : str
        Address for containers on the same host: a Unix socket.
    far : str
        Address for containers of other hosts; empty if it has none.
    fingerprint : str
        SHA-256 of its certificate for containers of other hosts, in hexadecimal.
    """

    machine: str
    near: str
    far: str = ""
    fingerprint: str = ""


def endpoint_socket(folder: Path, endpoint: str) -> Path:
    """Return the path of the socket that containers dial to reach an endpoint."""
    return folder / f"endpoint-{endpoint}.sock"


def is_endpoint_socket(path: Path, folder: Path) -> bool:
    """Return whether a path is an endpoint's socket in a folder."""
    return path.parent == folder and _ENDPOINT.fullmatch(path.name) is not None
