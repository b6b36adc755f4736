"""Targets of webhooks: which URLs and addresses a cloud may post to, so that users reach no private network."""

import ipaddress
from dataclasses import dataclass
from urllib.parse import SplitResult, urlsplit

from ppaas.errors import InvalidParameter

MAX_URL = 2048
"""Largest URL [characters]."""

_IPV6_GLOBAL = ipaddress.IPv6Network("2000::/3")
_NAT64 = ipaddress.IPv6Network("64:ff9b::/96")


@dataclass(frozen=True, slots=True)
class TargetRules:
    """What the operator of a cloud allows.

    Parameters
    ----------
    allow_private : bool
        Whether targets may have addresses that are not public, such as addresses of this host and its networks.
    allow_http : bool
        Whether targets may be reached without TLS.
    """

    allow_private: bool = False
    allow_http: bool = False

    def check(self, url: str) -> None:
        """Check the URL of a webhook; its address is checked again whenever it is resolved.

        Raises
        ------
        InvalidParameter
            It is no URL of a target, or the operator does not allow it.
        """
        parts = _parts(url)
        if parts.scheme == "http" and not self.allow_http:
            raise InvalidParameter("the URL of a webhook must be https://…; an operator can allow http")
        address = _literal(parts.hostname or "")
        if address is not None and not self.permits(address):
            raise InvalidParameter(f"the address {address} is not public: an operator can allow such targets")

    def permits(self, address: str) -> bool:
        """Return whether a target may have an address."""
        return self.allow_private or is_public(address)


def is_public(address: str) -> bool:
    """Return whether an address is one of the public internet, of a single host."""
    try:
        ip = ipaddress.ip_address(address)
    except ValueError:
        return False
    if isinstance(ip, ipaddress.IPv6Address):
        inner = _inner(ip)
        if inner is not None:
            return is_public(str(inner))
        if ip not in _IPV6_GLOBAL:
            return False
    return ip.is_global and not ip.is_multicast


def _inner(ip: ipaddress.IPv6Address) -> ipaddress.IPv4Address | None:
    """Return the IPv4 address to which packets for an IPv6 address go; None if it stands for none."""
    if ip in _NAT64:
        return ipaddress.IPv4Address(ip.packed[-4:])
    return ip.ipv4_mapped or ip.sixtofour or (None if ip.teredo is None else ip.teredo[1])


def _parts(url: str) -> SplitResult:
    bad = "the URL of a webhook must be https://HOST[:PORT][/PATH][?QUERY]"
    if len(url) > MAX_URL:
        raise InvalidParameter(f"the URL of a webhook may have {MAX_URL} characters, not {len(url)}")
    if not (url.isascii() and url.isprintable() and " " not in url):
        raise InvalidParameter(f"{bad}, with characters beyond ASCII encoded as %XX")
    try:
        parts = urlsplit(url)
        port = parts.port
    except ValueError as error:
        raise InvalidParameter(f"{bad}: {error}") from error
    if parts.scheme not in ("https", "http") or not parts.hostname or port == 0:
        raise InvalidParameter(bad)
    if "@" in parts.netloc or "#" in url:
        raise InvalidParameter(f"{bad}, without a login and without a fragment: deliveries are signed")
    return parts


def _literal(host: str) -> str | None:
    """Return the address that a host is written as; None for a name."""
    try:
        return str(ipaddress.ip_address(host))
    except ValueError:
        return None
