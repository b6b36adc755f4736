from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.protocols.address import TlsAddress, UnixAddress, parse_address, parse_host_port
from ppaas.errors import InvalidInput


def test_unix_path_is_parsed() -> None:
    assert parse_address("unix:/run/ppaas/link.sock") == UnixAddress(Path("/run/ppaas/link.sock"))


@pytest.mark.parametrize(("text", "host"), [("tls://cloud.example:8600", "cloud.example"), ("tls://[::1]:8600", "::1")])
def test_host_and_port_are_parsed(text: str, host: str) -> None:
    address = parse_address(text)
    assert address == TlsAddress(host, 8600)
    assert str(address) == text


@pytest.mark.parametrize(
    "text",
    ["", "/run/link.sock", "unix:link.sock", "tcp://h:1", "tls:h:1", "tls://h", "tls://:1", "tls://h:65536",
     "tls://h:-1", "tls://u@h:1", "tls://h:1/path", "tls://::1:8600", "tls://[::1:8600", "tls://h:x"],
)  # fmt: skip
def test_invalid_address_is_refused_with_the_expected_form(text: str) -> None:
    with pytest.raises(InvalidInput, match=r"write|from 0 to 65535"):
        parse_address(text)


@given(st.text())
def test_host_and_port_round_trip(text: str) -> None:
    try:
        address = parse_host_port(text)
    except InvalidInput:
        return
    assert parse_host_port(address.authority) == address
