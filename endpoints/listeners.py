"""Listening sockets of the web server, for IPv4 and IPv6, and the URL at which it is reached."""

import errno
import socket
from collections.abc import Sequence

from ppaas.errors import Unavailable

BACKLOG = 1024
"""Number of connections that wait to be accepted."""

ANY4, ANY6 = "0.0.0.0", "::"


def listen(host: str, port: int, *, shared: bool = False, accept: bool = True) -> list[socket.socket]:
    """Return listening sockets at all addresses of a host, on one port.

    IPv4 and IPv6 have a socket each, so addresses of IPv4 clients are not mapped into IPv6.

    Parameters
    ----------
    host : str
        Address or name of this host. ``::`` takes all addresses of IPv6 and, if the system has it, of IPv4.
    port : int
        Port; 0 takes a free one.
    shared : bool
        Whether other processes of this user may listen at the same address (``SO_REUSEPORT``): the system gives each
        connection to one of them.
    accept : bool
        Whether to accept connections. Without it, the sockets reserve the port only.

    Raises
    ------
    Unavailable
        The address does not belong to this host, or is in use.
    """
    opened: list[socket.socket] = []
    absent: OSError | None = None
    try:
        for family, address in _addresses(host, port):
            try:
                at = address, opened[0].getsockname()[1] if opened else port
                opened.append(_listener(family, at, shared=shared, accept=accept))
            except OSError as error:
                # A name may have addresses that the system does not, as localhost has ::1 without IPv6.
                if error.errno not in (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT):
                    raise
                absent = error
        if not opened and absent is not None:
            raise absent
    except OSError as error:
        for listener in opened:
            listener.close()
        raise Unavailable(
            f"cannot listen: {error.strerror}: host {host}, port {port}; "
            "choose another --host or --port (0: a free port)"
        ) from error
    return opened


def url_of(listener: socket.socket, scheme: str = "http") -> str:
    """Return the URL of a listening socket."""
    host, port = listener.getsockname()[:2]
    return url_at(host, port, scheme)


def url_at(host: str, port: int, scheme: str = "http") -> str:
    """Return the URL of a port; an IPv6 address has brackets (RFC 3986, 3.2.2)."""
    if ":" in host:
        host = f"[{host.replace('%', '%25')}]"  # the zone of a link-local address (RFC 6874)
    return f"{scheme}://{host}:{port}"


def _addresses(host: str, port: int) -> Sequence[tuple[socket.AddressFamily, str]]:
    """Return the addresses of a host, each once, IPv6 ones first where it is ``::``."""
    hosts = (ANY6, ANY4) if host == ANY6 else (host,)
    found = [
        (entry[0], str(entry[4][0]))
        for each in hosts
        for entry in socket.getaddrinfo(each, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    ]
    return list(dict.fromkeys(found))


def _listener(family: socket.AddressFamily, address: tuple[str, int], *, shared: bool, accept: bool) -> socket.socket:
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if shared:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        if family == socket.AF_INET6:
            listener.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        listener.bind(address)
        if accept:
            listener.listen(BACKLOG)
    except BaseException:
        listener.close()
        raise
    return listener
