"""Arguments of the front: path prefixes, trusted proxies, allowed origins."""

import pytest

from endpoints.http.front_settings import MAX_PREFIX, allowed_origin, is_prefix, may_open, root_path, trusted_proxy
from ppaas.errors import InvalidInput


@pytest.mark.parametrize(
    ("text", "path"), [("", ""), ("/", ""), ("/ppaas", "/ppaas"), ("/ppaas/", "/ppaas"), ("/a/b.c-d~1", "/a/b.c-d~1")]
)
def test_a_root_path_has_no_slash_at_its_end(text: str, path: str) -> None:
    assert root_path(text) == path


@pytest.mark.parametrize(
    "text",
    ["ppaas", "//evil.example", "/a//b", "/a b", "/a%20", "/../a", "/.", "/v1", "/dashboard/x", "/docs", "http://a/b",
     "/a?b", "/" + "a" * MAX_PREFIX, "/ä"],
)  # fmt: skip
def test_another_root_path_is_refused(text: str) -> None:
    assert not is_prefix(text)
    with pytest.raises(InvalidInput, match="looks like /ppaas"):
        root_path(text)


@pytest.mark.parametrize("text", ["127.0.0.1", "::1", "10.0.0.0/8", "fd00::/8"])
def test_a_trusted_proxy_is_an_address_or_a_network(text: str) -> None:
    assert trusted_proxy(text) == text


@pytest.mark.parametrize("text", ["*", "proxy.example", "10.0.0.1/8", "10.0.0.256", ""])
def test_another_trusted_proxy_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput, match=r"such as 127\.0\.0\.1 or 10\.0\.0\.0/8"):
        trusted_proxy(text)


@pytest.mark.parametrize(
    ("text", "origin"),
    [
        ("https://pages.example", "https://pages.example"),
        ("https://Pages.example:443/", "https://pages.example"),
        ("http://localhost:3000", "http://localhost:3000"),
        ("http://[::1]:80", "http://[::1]"),
        ("capacitor://localhost", "capacitor://localhost"),
        ("*", "*"),
        ("null", "null"),
    ],
)
def test_an_origin_is_spelled_as_browsers_spell_it(text: str, origin: str) -> None:
    assert allowed_origin(text) == origin


@pytest.mark.parametrize("text", ["pages.example", "https://", "https://a/b", "https://u@a", "https://a:x", "", "a*"])
def test_another_origin_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput, match="an origin looks like"):
        allowed_origin(text)


# Origins of pages that open WebSockets.


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
