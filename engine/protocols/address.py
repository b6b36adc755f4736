"""Addresses of links: ``unix:/path`` on one machine, ``tls://host:port`` between machines.

An endpoint has several addresses for containers, by which it may be dialled.
"""

import re
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlsplit

import msgspec

from ppaas.errors import InvalidInput

MAX_PORT = 65535


class UnixAddress(NamedTuple):
    """Address of a Unix socket, which only its owner may dial."""

    path: Path

    def __str__(self) -> str:
        return f"unix:{self.path}"


class TlsAddress(NamedTuple):
    """Port of a host, which only machines of the cloud may dial. To listen at port 0 means any free port."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"tls://{self.authority}"

    @property
    def authority(self) -> str:
        """Host and port in the syntax of URLs."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


Address = UnixAddress | TlsAddress


def parse_address(text: str) -> Address:
    """Parse an address.

    Raises
    ------
    InvalidInput
        The text is not an address.
    """
    scheme, _, rest = text.partition(":")
    if scheme == "unix" and rest.startswith("/"):
        return UnixAddress(Path(rest))
    if scheme == "tls" and rest.startswith("//"):
        return parse_host_port(rest.removeprefix("//"))
    raise InvalidInput(f"{text!r} is not an address: write unix:/path or tls://host:port")


EVERYWHERE = ("0.0.0.0", "::")
"""Hosts that stand for all addresses of a host."""


def reached_as(address: str, other: str) -> str:
    """Return an address as a host reaches it which reaches another port of the same host.

    Parameters
    ----------
    address : str
        Address; if its host is all addresses, the result has the host of ``other``.
    other : str
        Address of another port.

    Raises
    ------
    InvalidInput
        One of the texts is not an address.
    """
    here, known = parse_address(address), parse_address(other)
    if isinstance(here, TlsAddress) and isinstance(known, TlsAddress) and here.host in EVERYWHERE:
        return str(here._replace(host=known.host))
    return address


def parse_host_port(text: str) -> TlsAddress:
    """Parse ``host:port``, with an IPv6 address in brackets.

    Raises
    ------
    InvalidInput
        The text is not ``host:port``.
    """
    try:
        parts = urlsplit(f"//{text}")
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise InvalidInput(f"{text!r} is not host:port, with a port from 0 to {MAX_PORT}: {error}") from error
    if not host or port is None or parts.netloc != text or "@" in text:
        raise InvalidInput(f"{text!r} is not host:port; write an IPv6 address in brackets, as [::1]:8600")
    return TlsAddress(host, port)


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
