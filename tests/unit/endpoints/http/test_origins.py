"""Origins of pages that open WebSockets."""

import pytest

from endpoints.http.origins import may_open


@pytest.mark.parametrize(
    ("origin", "host"),
    [
        ("", "cloud:8500"),
        ("http://cloud:8500", "cloud:8500"),
        ("https://cloud", "cloud:8443"),
        ("http://localhost:3000", "127.0.0.1:8500"),
        ("http://[::1]:8500", "localhost:8500"),
        ("https://[2001:db8::1]", "[2001:db8::1]:8500"),
        ("https://CLOUD.example", "cloud.example"),
    ],
)
def test_pages_of_the_same_host_and_clients_without_a_page_may(origin: str, host: str) -> None:
    assert may_open(origin, host, ())


@pytest.mark.parametrize(
    ("origin", "host"),
    [
        ("https://evil.example", "cloud.example"),
        ("https://cloud.example.evil.example", "cloud.example"),
        ("null", "cloud"),
        ("file://", ""),
        ("http://[", "["),
        ("http://localhost:3000", "cloud"),
    ],
)
def test_pages_of_other_hosts_may_not_unless_they_are_allowed(origin: str, host: str) -> None:
    assert not may_open(origin, host, ("https://pages.example",))
    assert may_open(origin, host, ("https://pages.example", origin))
    assert may_open(origin, host, ("*",))
