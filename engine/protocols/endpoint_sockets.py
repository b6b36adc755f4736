"""Names of the sockets between endpoints and containers, in the folder of the cloud's sockets."""

import re
from pathlib import Path

RELAY = "relay.sock"
"""Name of the socket of a machine that relays to endpoints which its containers cannot dial."""

_ENDPOINT = re.compile(r"endpoint-[\w.-]+\.sock")


def endpoint_socket(folder: Path, endpoint: str) -> Path:
    """Return the path of the socket that containers dial to reach an endpoint."""
    return folder / f"endpoint-{endpoint}.sock"


def is_endpoint_socket(path: Path, folder: Path) -> bool:
    """Return whether a path is that of an endpoint's socket in a folder."""
    return path.parent == folder and _ENDPOINT.fullmatch(path.name) is not None
