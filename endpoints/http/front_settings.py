"""Settings of the front of a cloud: its path below a proxy, the proxies it trusts, and the web pages it allows."""

import ipaddress
import re
from collections.abc import Container
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

from ppaas.errors import InvalidInput

MAX_PREFIX = 256
"""Largest length of a path prefix [characters]."""

OWN_NAMES = frozenset({"v1", "dashboard", "docs", "docs-site", "openapi.json"})
"""First segments of the cloud's own paths, with which no prefix begins: it would hide them."""

ANY_ORIGIN = "*"
"""Allowed origin that stands for all."""

NO_ORIGIN = "null"
"""Origin of pages without one, such as files."""

_PREFIX = re.compile(r"(/[A-Za-z0-9._~-]+)+")


@dataclass(frozen=True, slots=True)
class FrontSettings:
    """Settings of the front of a cloud.

    Parameters
    ----------
    root_path : str
        Path below which a proxy serves the cloud, such as ``/ppaas``; empty at the root of its host.
    trusted_proxies : tuple of str
        Addresses and networks of proxies whose ``X-Forwarded-…`` headers are believed.
    allowed_origins : tuple of str
        Origins of web pages on other hosts that may use the cloud; ``*`` for all.
    docs_site : Path, optional
        Folder of the documentation site; that of a checkout by default.
    """

    root_path: str = ""
    trusted_proxies: tuple[str, ...] = ()
    allowed_origins: tuple[str, ...] = ()
    docs_site: Path | None = None


def is_prefix(text: str) -> bool:
    """Return whether a text is a path prefix: ``/name``, or several, the first of which is not the cloud's own."""
    own = text.split("/")[1:2]
    dots = {".", ".."} & set(text.split("/"))
    return len(text) <= MAX_PREFIX and bool(_PREFIX.fullmatch(text)) and not dots and not OWN_NAMES & set(own)


def root_path(text: str) -> str:
    """Return the path prefix in an argument; ``InvalidInput`` unless it is one."""
    prefix = text.rstrip("/")
    if prefix and not is_prefix(prefix):
        raise InvalidInput(
            f"a path prefix looks like /ppaas, of letters, digits and ._~-, and must not begin with one of the cloud's "
            f"own paths ({', '.join(sorted(OWN_NAMES))}); it is not {text!a}"
        )
    return prefix


def trusted_proxy(text: str) -> str:
    """Return the address or network in an argument; ``InvalidInput`` unless it is one."""
    try:
        return str(ipaddress.ip_network(text) if "/" in text else ipaddress.ip_address(text))
    except ValueError as error:
        raise InvalidInput(
            f"give the address or network of a proxy, such as 127.0.0.1 or 10.0.0.0/8: {error}"
        ) from error


def allowed_origin(text: str) -> str:
    """Return the origin in an argument, as browsers write it (RFC 6454, 6.1); ``InvalidInput`` unless it is one."""
    if text in (ANY_ORIGIN, NO_ORIGIN):
        return text
    try:
        parts = urlsplit(text)
        good = parts.scheme and parts.hostname and parts.port != 0 and parts.path in ("", "/")
    except ValueError:
        good = False
    if not good or parts.username is not None or parts.query or parts.fragment:
        raise InvalidInput(f"an origin looks like https://pages.example or http://localhost:3000, not {text!a}")
    default = {"http": 80, "https": 443}.get(parts.scheme)
    host = f"[{parts.hostname}]" if ":" in str(parts.hostname) else parts.hostname
    return f"{parts.scheme}://{host}" + (f":{parts.port}" if parts.port not in (None, default) else "")


# Origins of web pages that open a WebSocket: pages of the cloud's own host, and allowed origins.
#
# Browsers apply no rule to WebSockets themselves, and name the page in ``Origin`` (RFC 6455, 10.2). Clients that are
# no browser may send any ``Origin``, or none.


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
