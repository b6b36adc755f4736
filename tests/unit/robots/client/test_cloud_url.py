"""URLs of a cloud, which all clients read in the same way.

The kind: an address that one client takes and another drops, changes or misreads. Its members are a path, with and
without a slash at its end, schemes of HTTP and WebSocket, IPv6 hosts, redirects, and parts that have no meaning: a
user, a query, a fragment, spaces, ports out of range.
"""

import pytest

from ppaas import __version__
from ppaas.errors import InvalidInput, NotAuthenticated
from robots.client.cloud_url import CloudUrl, bearer, check_redirect
from robots.client.connection import Address
from robots.client.rest import RestClient


@pytest.mark.parametrize(
    ("url", "parts"),
    [
        ("http://cloud:8500", CloudUrl(False, "cloud:8500", "")),
        ("ws://cloud:8500/", CloudUrl(False, "cloud:8500", "")),
        ("https://cloud/ppaas", CloudUrl(True, "cloud", "/ppaas")),
        ("wss://cloud/a/b/", CloudUrl(True, "cloud", "/a/b")),
        ("http://[::1]:8500/ppaas", CloudUrl(False, "[::1]:8500", "/ppaas")),
    ],
)
def test_scheme_host_and_path_are_parsed(url: str, parts: CloudUrl) -> None:
    assert CloudUrl.parse(url) == parts


@pytest.mark.parametrize(
    "url",
    ["", "cloud:8500", "ftp://cloud", "http://", "http://cloud:port", "http://cloud:0", "http://cloud:70000",
     "http://[::1", "http://clöud", "http://cloud/a b", "http://cloud\n", "http://ann:secret@cloud", "http://cloud?a=1",
     "http://cloud/#robots"],
)  # fmt: skip
def test_another_form_is_refused_by_all_clients(url: str) -> None:
    with pytest.raises(InvalidInput, match="URL of the cloud must"):
        RestClient(url)
    with pytest.raises(InvalidInput, match="URL of the cloud must"):
        Address(url, robot="tb1", token="t", role="robot", session="s")


def test_the_token_is_in_a_header_and_not_in_the_address() -> None:
    address = Address("https://cloud/ppaas", robot="tb1", token="secret", role="robot", session="s")
    assert address.headers == {"Authorization": "Bearer secret"}
    query = f"robot=tb1&role=robot&status=1&session=s&software=ppaas%2F{__version__}&resume=none"
    assert address.at(None) == f"wss://cloud/ppaas/?{query}"


@pytest.mark.parametrize("token", ["a\r\nX: y", "schlüssel"])
def test_a_token_that_is_no_header_is_refused(token: str) -> None:
    with pytest.raises(NotAuthenticated, match="log in again"):
        bearer(token)


def test_a_redirect_is_reported_without_the_query() -> None:
    check_redirect("http://cloud", 200, None)
    with pytest.raises(InvalidInput, match=r"^http://cloud/ redirects to 'https://cloud/': give the URL"):
        check_redirect("http://cloud/?robot=tb1", 308, "https://cloud/?robot=tb1")
