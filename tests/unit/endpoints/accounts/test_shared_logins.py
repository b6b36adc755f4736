"""Logins that endpoints share: their throttle, tokens that are not stored, and tickets. First the throttle.

Members of the kind, guessing a password: one user from one address; one user from many addresses; many users from one
address; the old password of a change. None may lock the owner out.
"""

from typing import Any

import pytest

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.fair_queue import RequestOrigin
from endpoints.accounts.passwords import Passwords
from endpoints.accounts.shared_logins import (
    ADDRESS,
    FORGET,
    MAX_COUNTED,
    MAX_UNSAVED,
    UNSAVED_LIFETIME,
    USER,
    USER_AT_ADDRESS,
    LoginThrottle,
    UnsavedTokens,
)
from endpoints.accounts.socket_tickets import LIFETIME, MAX_OF_USER, SocketTickets
from endpoints.accounts.tokens import TokenCache
from ppaas.clock import ManualClock
from ppaas.errors import NotAuthenticated, NotFound, TooManyAttempts, Unavailable
from storage.memory.store import MemoryStore
from storage.records import Token

HOME, AWAY = "10.0.0.1", "10.9.9.9"


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def throttle(clock: ManualClock) -> LoginThrottle:
    return LoginThrottle(clock)


def fail(throttle: LoginThrottle, user: str, address: str, times: int = 1) -> None:
    for _ in range(times):
        throttle.failed(RequestOrigin(user, address))


def wait_of(throttle: LoginThrottle, user: str, address: str) -> float:
    try:
        throttle.admit(user, address)
    except TooManyAttempts as error:
        assert error.retry_after is not None
        return error.retry_after
    return 0.0


def test_a_few_failures_have_no_wait(throttle: LoginThrottle) -> None:
    fail(throttle, "ann", HOME, USER_AT_ADDRESS.failures - 1)
    assert throttle.admit("ann", HOME) == RequestOrigin("ann", HOME, known=False)


def test_each_failure_beyond_doubles_the_wait_up_to_a_limit(throttle: LoginThrottle, clock: ManualClock) -> None:
    fail(throttle, "ann", HOME, USER_AT_ADDRESS.failures)
    waits = []
    for _ in range(8):
        waits.append(wait_of(throttle, "ann", HOME))
        clock.advance(waits[-1])
        assert wait_of(throttle, "ann", HOME) == 0.0
        fail(throttle, "ann", HOME)
    assert waits == pytest.approx([1, 2, 4, 8, 16, 32, 60, 60])


def test_attempts_during_the_wait_do_not_extend_it(throttle: LoginThrottle, clock: ManualClock) -> None:
    fail(throttle, "ann", HOME, USER_AT_ADDRESS.failures)
    for _ in range(8):
        assert wait_of(throttle, "ann", HOME) > 0.0
        clock.advance(0.125)
    assert wait_of(throttle, "ann", HOME) == 0.0


def test_a_success_and_time_forget_failures(throttle: LoginThrottle, clock: ManualClock) -> None:
    fail(throttle, "ann", HOME, USER_AT_ADDRESS.failures)
    throttle.succeeded(RequestOrigin("ann", HOME))
    assert wait_of(throttle, "ann", HOME) == 0.0
    fail(throttle, "bob", HOME, 30)
    clock.advance(FORGET)
    assert wait_of(throttle, "bob", HOME) == 0.0


def test_guesses_from_many_addresses_do_not_lock_the_owner_out(throttle: LoginThrottle) -> None:
    throttle.succeeded(RequestOrigin("ann", HOME))
    for number in range(USER.failures):
        fail(throttle, "ann", f"10.1.0.{number}")
    assert wait_of(throttle, "ann", "10.1.0.200") > 0.0
    assert throttle.admit("ann", HOME).known


def test_guesses_of_many_users_at_one_address_delay_new_users_there_only(throttle: LoginThrottle) -> None:
    throttle.succeeded(RequestOrigin("ann", HOME))
    for number in range(ADDRESS.failures):
        fail(throttle, f"user{number}", HOME)
    assert wait_of(throttle, "bob", HOME) > 0.0
    assert wait_of(throttle, "bob", AWAY) == 0.0
    assert wait_of(throttle, "ann", HOME) == 0.0


def test_memory_is_bounded(throttle: LoginThrottle) -> None:
    for number in range(MAX_COUNTED + 10):
        fail(throttle, f"u{number}", f"a{number}")
        throttle.succeeded(RequestOrigin(f"u{number}", f"a{number}"))
    sizes = (throttle._of_pair._failures, throttle._of_user._failures, throttle._of_address._failures, throttle._known)
    assert all(len(counted) <= MAX_COUNTED for counted in sizes)


PASSWORD = "correct horse"


class FullStore(MemoryStore):
    """A store that can be read, and written only while it is not full."""

    is_full = False

    def add_token(self, token: Token) -> None:
        self._write()
        super().add_token(token)

    def remove_tokens(self, **arguments: Any) -> int:
        self._write()
        return super().remove_tokens(**arguments)

    def _write(self) -> None:
        if self.is_full:
            raise Unavailable("the disk is full: free space")


@pytest.fixture
def store() -> FullStore:
    return FullStore()


@pytest.fixture
async def accounts(store: FullStore, clock: ManualClock, passwords: Passwords) -> Accounts:
    made = Accounts(store, clock, passwords=passwords, cache=TokenCache(size=2, lifetime=0.0))
    await made.register("ann", PASSWORD)
    store.is_full = True
    return made


# Logins while the store refuses writes: an administrator must be able to log in and free space.


async def test_a_token_that_cannot_be_stored_works_for_a_while(accounts: Accounts, clock: ManualClock) -> None:
    login = await accounts.sign_in("ann", PASSWORD)
    assert login.expires == clock() + UNSAVED_LIFETIME
    assert (await accounts.authenticate(login.token)).id == "ann"
    clock.advance(UNSAVED_LIFETIME + 1.0)
    with pytest.raises(NotAuthenticated):
        await accounts.authenticate(login.token)


async def test_a_token_that_was_not_stored_can_be_revoked(accounts: Accounts) -> None:
    login = await accounts.sign_in("ann", PASSWORD)
    await accounts.register("bob", PASSWORD)
    with pytest.raises(NotFound):
        await accounts.revoke("bob", login.id)
    await accounts.revoke("ann", login.id)
    with pytest.raises(NotAuthenticated):
        await accounts.authenticate(login.token)


async def test_a_new_password_and_a_logout_end_tokens_that_were_not_stored(accounts: Accounts) -> None:
    first, kept = [await accounts.sign_in("ann", PASSWORD) for _ in range(2)]
    await accounts.change("ann", password="another horse", keep_token=kept.id)
    with pytest.raises(NotAuthenticated):
        await accounts.authenticate(first.token)
    assert (await accounts.authenticate(kept.token)).id == "ann"
    await accounts.revoke_all("ann")
    with pytest.raises(NotAuthenticated):
        await accounts.authenticate(kept.token)


async def test_a_removed_user_has_no_token_left(accounts: Accounts) -> None:
    login = await accounts.sign_in("ann", PASSWORD)
    await accounts.remove("ann")
    await accounts.register("ann", PASSWORD)
    with pytest.raises(NotAuthenticated):
        await accounts.authenticate(login.token)


async def test_a_login_succeeds_if_only_the_removal_of_old_tokens_fails(
    accounts: Accounts, store: FullStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(store, "add_token", lambda token: MemoryStore.add_token(store, token))
    login = await accounts.sign_in("ann", PASSWORD)
    assert store.token(login.id).user == "ann"


def test_of_many_tokens_the_oldest_are_forgotten() -> None:
    tokens = UnsavedTokens()
    for number in range(MAX_UNSAVED + 1):
        tokens.add(Token(f"t{number}", "ann", 10.0))
    assert tokens.find("t0") is None
    assert tokens.find("t1") is not None


@pytest.fixture
def tickets(clock: ManualClock) -> SocketTickets:
    return SocketTickets(clock)


# Tickets for one handshake each.


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
