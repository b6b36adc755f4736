"""Tickets for one handshake each."""

import pytest

from endpoints.accounts.socket_tickets import LIFETIME, MAX_OF_USER, SocketTickets
from ppaas.clock import ManualClock
from ppaas.errors import NotAuthenticated


@pytest.fixture
def tickets(clock: ManualClock) -> SocketTickets:
    return SocketTickets(clock)


def test_a_ticket_is_redeemed_once(tickets: SocketTickets) -> None:
    first, second = tickets.issue("ann", "hash 1"), tickets.issue("ann", "hash 2")
    assert tickets.redeem(second) == "hash 2"
    assert tickets.redeem(first) == "hash 1"
    for used in (first, second, "", "unknown"):
        with pytest.raises(NotAuthenticated, match="POST /v1/tickets for each connection"):
            tickets.redeem(used)
    assert len(tickets) == 0


def test_a_ticket_expires(tickets: SocketTickets, clock: ManualClock) -> None:
    late, early = tickets.issue("ann", "hash"), tickets.issue("ann", "hash")
    clock.advance(LIFETIME - 0.1)
    assert tickets.redeem(early) == "hash"
    clock.advance(0.1)
    with pytest.raises(NotAuthenticated, match="older than 30 s"):
        tickets.redeem(late)


def test_expired_tickets_are_dropped_when_others_are_issued(tickets: SocketTickets, clock: ManualClock) -> None:
    for user in ("ann", "bob", "ann"):
        tickets.issue(user, "hash")
    clock.advance(LIFETIME)
    tickets.issue("cid", "hash")
    assert len(tickets) == 1


def test_the_oldest_tickets_of_a_user_make_room_for_new_ones(tickets: SocketTickets) -> None:
    other = tickets.issue("bob", "hash")
    issued = [tickets.issue("ann", f"hash {number}") for number in range(MAX_OF_USER + 2)]
    assert len(tickets) == MAX_OF_USER + 1
    with pytest.raises(NotAuthenticated):
        tickets.redeem(issued[1])
    assert tickets.redeem(issued[2]) == "hash 2"
    assert tickets.redeem(other) == "hash"
