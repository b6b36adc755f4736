"""Handshakes that are expected."""

import pytest

from engine.protocols.handshakes import PendingHandshakes
from ppaas.errors import NotPermitted


def test_an_expected_connection_is_admitted_once() -> None:
    awaited: PendingHandshakes[int] = PendingHandshakes()
    awaited.expect("c1", "secret", 7)
    assert len(awaited) == 1
    assert awaited.admit("c1", "secret") == 7
    assert len(awaited) == 0
    with pytest.raises(NotPermitted):
        awaited.admit("c1", "secret")


@pytest.mark.parametrize("given", ["", "wrong", "Secret", "sécret", "\0"])
def test_a_wrong_secret_leaves_the_connection_expected(given: str) -> None:
    awaited: PendingHandshakes[int] = PendingHandshakes()
    awaited.expect("c1", "secret", 7)
    with pytest.raises(NotPermitted):
        awaited.admit("c1", given)
    assert awaited.admit("c1", "secret") == 7


def test_a_forgotten_connection_is_refused() -> None:
    awaited: PendingHandshakes[int] = PendingHandshakes()
    awaited.expect("c1", "secret", 7)
    awaited.forget("c1")
    awaited.forget("c1")
    with pytest.raises(NotPermitted):
        awaited.admit("c1", "secret")
