"""Targets of webhooks: URLs and addresses that users may not give."""

import pytest

from endpoints.webhooks.targets import MAX_URL, TargetRules, is_public
from ppaas.errors import InvalidParameter

PRIVATE = [
    "127.0.0.1", "127.8.8.8", "10.0.0.1", "172.16.0.1", "192.168.1.1", "169.254.169.254", "0.0.0.0", "100.64.0.1",
    "224.0.0.1", "255.255.255.255", "240.0.0.1", "192.0.2.1", "198.18.0.1", "::", "::1", "fe80::1", "fc00::1",
    "ff02::1",    "fec0::1", "2001:db8::1", "::ffff:127.0.0.1", "::ffff:10.0.0.1", "64:ff9b::a00:1", "64:ff9b::7f00:1",
    "2002:a00:1::1", "2002:7f00:1::", "::127.0.0.1", "2001:0:0:0:0:0:80ff:fffe", "fe80::1%eth0", "no address", "",
]  # fmt: skip
PUBLIC = ["8.8.8.8", "1.1.1.1", "2001:4860:4860::8888", "2a00:1450::1", "::ffff:8.8.8.8", "64:ff9b::808:808"]


@pytest.mark.parametrize("address", PRIVATE)
def test_an_address_that_is_not_public_is_permitted_only_by_the_operator(address: str) -> None:
    assert not is_public(address)
    assert not TargetRules().permits(address)
    assert TargetRules(allow_private=True).permits(address)


@pytest.mark.parametrize("address", PUBLIC)
def test_a_public_address_is_permitted(address: str) -> None:
    assert TargetRules().permits(address)


@pytest.mark.parametrize(
    "url",
    ["https://example.org", "https://example.org:8443/a/b?c=%20d", "https://8.8.8.8/x", "https://[2a00:1450::1]:8/"],
)
def test_a_url_of_a_public_target_is_accepted(url: str) -> None:
    TargetRules().check(url)


@pytest.mark.parametrize(
    ("url", "reason"),
    [
        ("http://example.org", "operator can allow http"),
        ("ftp://example.org", "must be https"),
        ("https://", "must be https"),
        ("example.org", "must be https"),
        ("https://example.org:99999/", "Port out of range"),
        ("https://example.org:0/", "must be https"),
        ("https://ann:secret@example.org/", "without a login"),
        ("https://example.org/#part", "without a fragment"),
        ("https://example.org/a b", "ASCII"),
        ("https://example.org/\r\nX-Other: 1", "ASCII"),
        ("https://exämple.org/", "ASCII"),
        ("https://[::1", "Invalid IPv6"),
        ("https://127.0.0.1/", "not public"),
        ("https://[::1]/", "not public"),
        ("https://169.254.169.254/latest/meta-data", "not public"),
        ("https://example.org/" + "a" * MAX_URL, "may have"),
    ],
)
def test_another_url_is_refused_with_the_reason(url: str, reason: str) -> None:
    with pytest.raises(InvalidParameter, match=reason):
        TargetRules().check(url)


def test_an_operator_allows_http_and_private_addresses() -> None:
    TargetRules(allow_private=True, allow_http=True).check("http://127.0.0.1:8000/x")
    with pytest.raises(InvalidParameter, match="http"):
        TargetRules(allow_private=True).check("http://127.0.0.1:8000/x")
