"""Hosts of devices: the operator of a cloud lists them, so that users of it reach nothing else in its networks."""

import asyncio
import ipaddress
import socket
from collections.abc import Iterable

from ppaas.errors import InvalidInput, NotPermitted, Unavailable

RESOLUTION = 3.0
"""Time limit of the resolution of a name [s]."""


class DeviceHosts:
    """Hosts that devices may have.

    Parameters
    ----------
    allowed : iterable of str
        Names (``lifts.example``), addresses (``10.0.0.7``), networks (``10.0.0.0/24``), each with a port behind a colon
        if only that one is allowed (``lifts.example:8080``, ``[fd00::1]:502``). None by default.

    Raises
    ------
    InvalidInput
        One of them has another form.
    """

    def __init__(self, allowed: Iterable[str] = ()) -> None:
        self._names: set[tuple[str, int | None]] = set()
        self._networks: list[tuple[ipaddress.IPv4Network | ipaddress.IPv6Network, int | None]] = []
        for text in allowed:
            host, port = _split(text)
            try:
                self._networks.append((ipaddress.ip_network(host), port))
            except ValueError as error:
                if "/" in host or not host or " " in host:
                    raise InvalidInput(
                        f"a host of devices is a name, an address or a network, not {text!r}: {error}"
                    ) from error
                self._names.add((host.lower(), port))

    async def address(self, host: str, port: int) -> str:
        """Return the host or the address to connect to.

        A name that is listed is connected to as it resolves; any other, only at an address that is listed.

        Raises
        ------
        NotPermitted
            The operator has not listed it.
        Unavailable
            The name cannot be resolved.
        """
        if self._names & {(host.lower(), None), (host.lower(), port)}:
            return host
        refusal = f"the operator of the cloud has not listed {host}:{port} as a host of devices"
        if not self._networks:
            raise NotPermitted(refusal)
        try:
            async with asyncio.timeout(RESOLUTION):
                found = await asyncio.get_running_loop().getaddrinfo(host, port, type=socket.SOCK_STREAM)
        except (OSError, TimeoutError) as error:
            raise Unavailable(f"the name {host!r} of a device cannot be resolved: {error}") from error
        for entry in found:
            address = ipaddress.ip_address(entry[4][0])
            if any(address in network and allowed in (None, port) for network, allowed in self._networks):
                return str(address)
        raise NotPermitted(refusal)


def _split(text: str) -> tuple[str, int | None]:
    """Return host and port of an entry."""
    host, colon, port = text.rpartition(":")
    if host.startswith("[") and host.endswith("]"):
        host = host[1:-1]
    elif not colon or ":" in host:  # no port: a name, an IPv4 address, or an IPv6 one without brackets
        return text.removeprefix("[").removesuffix("]"), None
    if not (port.isascii() and port.isdecimal() and 0 < int(port) < 65536):
        raise InvalidInput(f"the port of a host of devices is a number up to 65535, not {port!r}")
    return host, int(port)
