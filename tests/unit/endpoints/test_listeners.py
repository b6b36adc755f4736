"""Listening sockets for IPv4 and IPv6.

The kind: addresses that are not IPv4. Its members are an IPv6 address, all addresses of both, a name that has both, and
the brackets of an IPv6 address in a URL.
"""

import socket
from contextlib import ExitStack

import pytest

from endpoints.listeners import listen, url_of
from ppaas.errors import Unavailable
from tests.support.network.ipv6 import needs_ipv6


def reached(host: str, *clients: str) -> list[str]:
    """Listen at a host, connect to these addresses, and return the addresses that the server sees."""
    seen = []
    with ExitStack() as stack:
        listeners = [stack.enter_context(each) for each in listen(host, 0)]
        port = listeners[0].getsockname()[1]
        assert {each.getsockname()[1] for each in listeners} == {port}
        for client in clients:
            with socket.create_connection((client, port), timeout=10):
                family = socket.AF_INET6 if ":" in client else socket.AF_INET
                [listener] = [each for each in listeners if each.family == family]
                accepted, address = listener.accept()
                accepted.close()
                seen.append(address[0])
    return seen


def test_an_ipv4_address_is_listened_at() -> None:
    assert reached("127.0.0.1", "127.0.0.1") == ["127.0.0.1"]


@needs_ipv6
def test_an_ipv6_address_is_listened_at() -> None:
    assert reached("::1", "::1") == ["::1"]


@needs_ipv6
@pytest.mark.parametrize("host", ["::", "localhost"])
def test_both_are_listened_at_and_clients_of_ipv4_keep_their_addresses(host: str) -> None:
    addresses = ["127.0.0.1"]
    if host == "::" or {"::1"} & {str(entry[4][0]) for entry in socket.getaddrinfo(host, 0)}:
        addresses.append("::1")
    assert reached(host, *addresses) == addresses


def test_a_system_without_ipv6_listens_at_ipv4(monkeypatch: pytest.MonkeyPatch) -> None:
    opened = socket.socket

    def without_ipv6(family: int, *options: int) -> socket.socket:
        if family == socket.AF_INET6:
            raise OSError(97, "Address family not supported by protocol")
        return opened(family, *options)

    monkeypatch.setattr(socket, "socket", without_ipv6)
    [listener] = listen("::", 0)
    with listener:
        assert url_of(listener).startswith("http://0.0.0.0:")
    with pytest.raises(Unavailable, match="Address family not supported"):
        listen("::1", 0)


def test_a_port_in_use_leaves_no_socket_open() -> None:
    with (
        socket.create_server(("127.0.0.1", 0)) as other,
        pytest.raises(Unavailable, match=r"in use: host 127\.0\.0\.1, port \d+; choose another --host or --port"),
    ):
        listen("127.0.0.1", other.getsockname()[1])


def test_an_unknown_name_is_reported() -> None:
    with pytest.raises(Unavailable, match=r"cannot listen: .*; choose another --host"):
        listen("no-such-host.invalid", 0)


@needs_ipv6
def test_the_url_of_an_ipv6_address_has_brackets() -> None:
    [listener] = listen("::1", 0)
    with listener:
        assert url_of(listener) == f"http://[::1]:{listener.getsockname()[1]}"
        assert url_of(listener, "https").startswith("https://[::1]:")
