"""Posts to the targets of webhooks: no redirects, no addresses that are not allowed, and a limit of time.

The address is checked where it is connected to, after the name was resolved: a name may resolve to another address than
before.
"""

import asyncio
import socket
import ssl
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import httpcore

from endpoints.webhooks.targets import TargetRules
from ppaas.errors import NotPermitted, Unavailable

TIMEOUT = 15.0
"""Time limit of an attempt, from the resolution of the name to the head of the answer [s]."""

CONNECT_TIMEOUT = 5.0
"""Time limit of a connection to one address [s]."""

MOST_ADDRESSES = 4
"""Largest number of addresses of a target that are tried."""

LONGEST_WAIT = 6 * 3600.0
"""Longest time that a target may ask to wait [s]."""


class PostAnswer(NamedTuple):
    """Answer of a target: its status, and for how long it asks to wait [s]."""

    status: int
    wait: float


class GuardedNetwork(httpcore.AsyncNetworkBackend):
    """Connects to allowed addresses alone.

    Parameters
    ----------
    rules : TargetRules
    """

    def __init__(self, rules: TargetRules) -> None:
        self._rules = rules
        self._network = httpcore.AnyIOBackend()

    async def connect_tcp(
        self,
        host: str,
        port: int,
        timeout: float | None = None,
        local_address: str | None = None,
        socket_options: Iterable[httpcore.SOCKET_OPTION] | None = None,
    ) -> httpcore.AsyncNetworkStream:
        """Resolve a name, and connect to the first of its addresses that is allowed and answers.

        Raises
        ------
        NotPermitted
            None of its addresses is allowed.
        """
        found = await asyncio.get_running_loop().getaddrinfo(host, port, type=socket.SOCK_STREAM)
        addresses = list(dict.fromkeys(str(each[4][0]) for each in found))
        allowed = [address for address in addresses if self._rules.permits(address)][:MOST_ADDRESSES]
        if not allowed:
            raise NotPermitted(f"{host} has no public address, and others are not allowed: {', '.join(addresses[:4])}")
        *others, last = allowed
        for address in others:
            try:
                return await self._network.connect_tcp(address, port, timeout, local_address, socket_options)
            except (httpcore.NetworkError, httpcore.TimeoutException):
                continue
        return await self._network.connect_tcp(last, port, timeout, local_address, socket_options)

    async def sleep(self, seconds: float) -> None:
        """Sleep between two attempts."""
        await self._network.sleep(seconds)


class Poster:
    """Posts to targets.

    Parameters
    ----------
    rules : TargetRules
    timeout : float
        Time limit of a post [s].
    """

    def __init__(self, rules: TargetRules, timeout: float = TIMEOUT) -> None:
        self._rules = rules
        self._timeout = timeout
        self._tls = ssl.create_default_context()

    async def post(self, url: str, headers: Mapping[str, str], body: bytes) -> PostAnswer:
        """Post; return the answer, whose body is not read.

        Raises
        ------
        NotPermitted
            The target has no allowed address.
        Unavailable
            There was no answer; the text says why.
        """
        limits = {"connect": CONNECT_TIMEOUT, "read": self._timeout, "write": self._timeout, "pool": self._timeout}
        try:
            async with (
                asyncio.timeout(self._timeout),
                httpcore.AsyncConnectionPool(
                    ssl_context=self._tls, network_backend=GuardedNetwork(self._rules)
                ) as pool,
                pool.stream(
                    "POST", url, headers=list(headers.items()), content=body, extensions={"timeout": limits}
                ) as response,
            ):
                return PostAnswer(response.status, _wait(response.headers))
        except (TimeoutError, httpcore.TimeoutException) as error:
            raise Unavailable(f"no answer within {self._timeout:g} s") from error
        except (OSError, httpcore.NetworkError, httpcore.ProtocolError) as error:
            raise Unavailable(f"no answer: {error}"[:200]) from error


def _wait(headers: Iterable[tuple[bytes, bytes]]) -> float:
    """Return for how long an answer asks to wait [s]; 0 if it does not say so in seconds."""
    for name, value in headers:
        if name.lower() == b"retry-after" and value.isdigit():
            return min(float(value[:9]), LONGEST_WAIT)
    return 0.0
