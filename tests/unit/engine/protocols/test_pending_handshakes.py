import pytest

from engine.protocols.pending_handshakes import PendingHandshakes
from ppaas.errors import NotPermitted


def test_whoever_is_awaited_is_admitted_once() -> None:
    awaited: PendingHandshakes[int] = PendingHandshakes()
    awaited.expect("c1", "secret", 7)
    assert len(awaited) == 1
    assert awaited.admit("c1", "secret") == 7
    assert len(awaited) == 0
    with pytest.raises(NotPermitted):
        awaited.admit("c1", "secret")


@pytest.mark.parametrize("given", ["", "wrong", "Secret", "sécret", "\0"])
def test_a_stranger_with_a_wrong_secret_does_not_take_the_place_of_the_awaited(given: str) -> None:
    awaited: PendingHandshakes[int] = PendingHandshakes()
    awaited.expect("c1", "secret", 7)
    with pytest.raises(NotPermitted):
        awaited.admit("c1", given)
    assert awaited.admit("c1", "secret") == 7


def test_who_is_forgotten_is_a_stranger() -> None:
    awaited: PendingHandshakes[int] = PendingHandshakes()
    awaited.expect("c1", "secret", 7)
    awaited.forget("c1")
    awaited.forget("c1")
    with pytest.raises(NotPermitted):
        awaited.admit("c1", "secret")
