"""Addresses of masters on disk."""

from pathlib import Path

import pytest

from engine.protocols.address import TlsAddress
from engine.remote.masters import FILE, MOST, KnownMasters


def test_addresses_are_noted_once_the_latest_first_and_found_again(tmp_path: Path) -> None:
    masters = KnownMasters(tmp_path)
    assert masters.texts() == ()
    assert masters.note(("tls://a:1",))
    assert masters.note(("tls://b:2", "tls://[::1]:3"))
    assert not masters.note(("tls://a:1",))
    assert KnownMasters(tmp_path).addresses == masters.addresses == (
        TlsAddress("b", 2), TlsAddress("::1", 3), TlsAddress("a", 1),
    )  # fmt: skip
    assert masters.texts() == ("tls://b:2", "tls://[::1]:3", "tls://a:1")


def test_the_number_of_addresses_is_bounded(tmp_path: Path) -> None:
    masters = KnownMasters(tmp_path)
    for port in range(1, 3 * MOST):
        masters.note((f"tls://a:{port}",))
    assert [address.port for address in masters.addresses] == list(range(3 * MOST - 1, 2 * MOST - 1, -1))


def test_what_is_no_address_of_a_port_is_left_out(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    masters = KnownMasters(tmp_path)
    assert not masters.note(("unix:/run/x", "tls://", "nonsense", "tls://a:99999"))
    assert masters.addresses == ()
    assert "left out" in caplog.text


@pytest.mark.parametrize("content", ["{", '["nonsense"]', "7"])
def test_a_damaged_file_counts_as_empty(tmp_path: Path, content: str) -> None:
    (tmp_path / FILE).write_text(content)
    assert KnownMasters(tmp_path).addresses == ()
