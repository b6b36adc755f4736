"""Where a link is listened at: ``unix:/path`` on one machine, ``tls://host:port`` between machines."""

from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlsplit

from ppaas.errors import InvalidInput

MAX_PORT = 65535


class UnixAddress(NamedTuple):
    """A Unix socket, which only its owner may dial."""

    path: Path

    def __str__(self) -> str:
        return f"unix:{self.path}"


class TlsAddress(NamedTuple):
    """A port of a host, which only machines of the cloud may dial. Port 0, to listen at, is any that is free."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"tls://{self.authority}"

    @property
    def authority(self) -> str:
        """Host and port as a URL writes them."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


Address = UnixAddress | TlsAddress


def parse_address(text: str) -> Address:
    """Read an address.

    Raises
    ------
    InvalidInput
        It is none.
    """
    scheme, _, rest = text.partition(":")
    if scheme == "unix" and rest.startswith("/"):
        return UnixAddress(Path(rest))
    if scheme == "tls" and rest.startswith("//"):
        return parse_host_port(rest.removeprefix("//"))
    raise InvalidInput(f"{text!r} is no address of a link: write unix:/path or tls://host:port")


def parse_host_port(text: str) -> TlsAddress:
    """Read ``host:port``, an IPv6 address in brackets.

    Raises
    ------
    InvalidInput
        It is something else.
    """
    try:
        parts = urlsplit(f"//{text}")
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise InvalidInput(f"{text!r} is not host:port, with a port from 0 to {MAX_PORT}: {error}") from error
    if not host or port is None or parts.netloc != text or "@" in text:
        raise InvalidInput(f"{text!r} is not host:port; write an IPv6 address in brackets, as [::1]:8600")
    return TlsAddress(host, port)
