"""Origins of web pages that open a WebSocket: pages of the cloud's own host, and allowed origins.

Browsers apply no rule to WebSockets themselves, and name the page in ``Origin`` (RFC 6455, 10.2). Clients that are no
browser may send any ``Origin``, or none.
"""

import ipaddress
from collections.abc import Container
from urllib.parse import urlsplit

from endpoints.http.front_settings import ANY_ORIGIN


def may_open(origin: str, host: str, allowed: Container[str]) -> bool:
    """Return whether a page may open a WebSocket.

    Parameters
    ----------
    origin : str
        Origin of the page; empty if the client is no browser.
    host : str
        Host of the request, perhaps with a port. Ports and schemes of pages on the same host are not compared, because
        proxies change them.
    allowed : container of str
        Origins of other hosts that may, ``*`` for all.
    """
    return not origin or ANY_ORIGIN in allowed or origin in allowed or _is_same(_host_of(origin), _host_of(f"//{host}"))


def _host_of(url: str) -> str:
    try:
        return urlsplit(url).hostname or ""
    except ValueError:
        return ""


def _is_same(one: str, other: str) -> bool:
    return one != "" and (one == other or (_is_loopback(one) and _is_loopback(other)))


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost" or host.endswith(".localhost")
