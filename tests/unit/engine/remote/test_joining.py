"""Tickets of machines."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.protocols.address import TlsAddress
from engine.remote.joining import PREFIX, Tickets, read_ticket
from ppaas.errors import InvalidInput, NotPermitted

CLOUD = TlsAddress("cloud.example", 8600)


class Time:
    now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def time() -> Time:
    return Time()


@pytest.fixture
def tickets(tmp_path: Path, time: Time) -> Tickets:
    return Tickets(tmp_path / "tickets", time)


def test_a_ticket_is_decoded_from_its_text(tickets: Tickets) -> None:
    ticket = tickets.make(CLOUD, "ab" * 32, valid=60.0)
    assert read_ticket(f" {ticket}\n") == ticket
    assert ticket.address == CLOUD


def test_ticket_is_valid_once_across_processes(tickets: Tickets, tmp_path: Path) -> None:
    ticket = tickets.make(CLOUD, "", valid=60.0)
    again = Tickets(tmp_path / "tickets", Time())
    assert not again.use(ticket.secret, "m1")
    with pytest.raises(NotPermitted, match="was used"):
        tickets.use(ticket.secret, "m1")


def test_ticket_expires(tickets: Tickets, time: Time) -> None:
    ticket = tickets.make(CLOUD, "", valid=60.0)
    time.now += 61.0
    with pytest.raises(NotPermitted, match="expired"):
        tickets.use(ticket.secret, "m1")


def test_a_ticket_for_a_machine_is_not_used_up_by_another(tickets: Tickets) -> None:
    ticket = tickets.make(CLOUD, "", valid=60.0, machine="m1")
    with pytest.raises(NotPermitted, match="--name m1"):
        tickets.use(ticket.secret, "m2")
    assert tickets.use(ticket.secret, "m1")


def test_ticket_secret_is_not_stored(tickets: Tickets, tmp_path: Path) -> None:
    ticket = tickets.make(CLOUD, "", valid=60.0)
    (file,) = (tmp_path / "tickets").iterdir()
    assert ticket.secret not in file.name + file.read_text()
    assert file.stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("secret", ["", "../x", "\0", "ä" * 1000])
def test_unknown_secret_is_refused(tickets: Tickets, secret: str) -> None:
    with pytest.raises(NotPermitted, match="unknown"):
        tickets.use(secret, "m1")


def test_a_ticket_for_an_invalid_name_is_refused(tickets: Tickets) -> None:
    with pytest.raises(InvalidInput, match="not a valid name"):
        tickets.make(CLOUD, "", valid=1.0, machine="../x")


def test_a_folder_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InvalidInput, match="cannot be stored"):
        Tickets(tmp_path / "file").make(CLOUD, "", valid=1.0)


@given(st.text() | st.text("abcXYZ-_=").map(PREFIX.__add__))
def test_an_invalid_ticket_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput, match="not a ticket"):
        read_ticket(text)
