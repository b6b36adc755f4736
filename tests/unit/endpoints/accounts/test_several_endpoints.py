"""Accounts of two endpoints of one cloud: what one changes, the other follows.

Faults: the process that keeps the logins cannot be reached, from one endpoint or both; so the other is not told.
"""

import asyncio
import contextlib
import threading
import time
from collections.abc import Awaitable, Callable
from typing import Any, NoReturn, cast

import msgspec
import pytest

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.accounts.shared_logins import LocalLogins, SharedLogins
from endpoints.accounts.tokens import TokenCache, token_id
from endpoints.accounts.user_turns import LocalTurns
from ppaas.clock import ManualClock
from ppaas.errors import NotAuthenticated, TooManyAttempts, Unavailable
from storage.memory.store import MemoryStore
from storage.records import Token, User
from tests.support.waiting import until

PASSWORD = "correct horse"
LIFETIME = 30.0


class Link:
    """Logins that two endpoints share, over a link that a test cuts."""

    def __init__(self) -> None:
        self.logins = LocalLogins()
        self.is_cut = False

    def __getattr__(self, name: str) -> Any:
        return self._fail if self.is_cut else getattr(self.logins, name)

    async def _fail(self, *_arguments: object) -> NoReturn:
        raise Unavailable("the master does not answer")


class FullStore(MemoryStore):
    """A store that takes no token while it is full, and takes its time, so that two changes overlap if they can."""

    is_full = False
    keeps_tokens = False

    def remove_token(self, token_hash: str) -> None:
        if self.keeps_tokens:
            raise Unavailable("the disk is full: free space")
        super().remove_token(token_hash)

    def user(self, user_id: str) -> User:
        found = super().user(user_id)
        time.sleep(0.002)
        return found

    def add_token(self, token: Token) -> None:
        if self.is_full:
            raise Unavailable("the disk is full: free space")
        super().add_token(token)


@pytest.fixture
def link() -> Link:
    return Link()


@pytest.fixture
def store() -> FullStore:
    return FullStore()


@pytest.fixture
async def both(store: FullStore, clock: ManualClock, passwords: Passwords, link: Link) -> list[Accounts]:
    """Return the accounts of two endpoints that share everything but their caches."""
    turns = LocalTurns()
    made = [
        Accounts(
            store,
            clock,
            passwords=passwords,
            cache=TokenCache(lifetime=LIFETIME),
            logins=cast(SharedLogins, link),
            turns=turns,
        )
        for _ in range(2)
    ]
    for accounts in made:
        link.logins.on_forget(accounts.forget_user)
    await made[0].register("ann", PASSWORD, groups=("staff",))
    return made


CHANGES: dict[str, Callable[[Accounts, str], Awaitable[object]]] = {
    "a new password": lambda accounts, _: accounts.change("ann", password="battery staple"),
    "a revoked token": lambda accounts, token: accounts.revoke("ann", token_id(token)),
    "the end of all sessions": lambda accounts, _: accounts.revoke_all("ann"),
    "a removed user": lambda accounts, _: accounts.remove("ann"),
}


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("is_full", [False, True])
async def test_what_one_endpoint_revokes_the_other_refuses_at_once(
    both: list[Accounts], store: FullStore, change: str, is_full: bool
) -> None:
    first = both[0]
    store.is_full = is_full  # the token is kept in memory then
    token = await first.login("ann", PASSWORD)
    for accounts in both:
        assert (await accounts.authenticate(token)).id == "ann"
    await CHANGES[change](first, token)
    for accounts in both:
        with pytest.raises(NotAuthenticated):
            await accounts.authenticate(token)


async def test_new_roles_groups_limits_and_passwords_of_robots_are_followed_at_once(both: list[Accounts]) -> None:
    first, second = both
    token = await first.login("ann", PASSWORD)

    async def seen() -> User:
        return await second.authenticate(token)

    assert (await seen()).groups == ("staff",)
    await first.change("ann", regroup=lambda _: ())
    assert (await seen()).groups == ()
    await first.change("ann", limits={"maps": 3})
    assert (await seen()).limits.maps == 3
    await first.rapyuta.set("ann", "battery staple")
    assert (await seen()).rapyuta_hash
    await first.change("ann", role="admin")
    assert (await seen()).role == "admin"


async def test_endpoints_that_start_at_once_create_one_administrator(both: list[Accounts]) -> None:
    first, second = await asyncio.gather(*(accounts.ensure_admin(PASSWORD) for accounts in both))
    assert first == second
    assert (await both[0].authenticate(await both[1].login("admin", PASSWORD))).role == "admin"


async def test_concurrent_changes_by_two_endpoints_are_all_kept(both: list[Accounts]) -> None:
    def join(group: str) -> Callable[[tuple[str, ...]], tuple[str, ...]]:
        return lambda known: (*known, group)

    changes = [both[number % 2].change("ann", regroup=join(f"g{number}")) for number in range(8)]
    changes += [both[0].change("ann", limits={"maps": 3}), both[1].change("ann", limits={"robots": 4})]
    await asyncio.gather(*changes, both[1].rapyuta.set("ann", "battery staple"))
    user = await both[0].authenticate(await both[0].login("ann", PASSWORD))
    assert sorted(user.groups) == ["g0", "g1", "g2", "g3", "g4", "g5", "g6", "g7", "staff"]
    assert (user.limits.maps, user.limits.robots) == (3, 4)
    assert user.rapyuta_hash


async def test_failed_logins_count_over_all_endpoints(both: list[Accounts]) -> None:
    for number in range(10):
        with pytest.raises(NotAuthenticated):
            await both[number % 2].sign_in("ann", "guess", "10.0.0.1")
    for accounts in both:
        with pytest.raises(TooManyAttempts):
            await accounts.sign_in("ann", PASSWORD, "10.0.0.1")


async def test_a_ticket_of_one_endpoint_is_redeemed_at_another_and_only_once(both: list[Accounts]) -> None:
    ticket = await both[0].issue_ticket("ann", "hash")
    assert await both[1].redeem_ticket(ticket) == "hash"
    with pytest.raises(NotAuthenticated):
        await both[0].redeem_ticket(ticket)


async def test_names_that_are_no_text_can_be_sent_to_the_other_process(
    both: list[Accounts], link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent = list[bytes]()

    async def admit(*arguments: Any) -> NoReturn:
        sent.append(msgspec.msgpack.encode(arguments))
        raise TooManyAttempts("wait")

    monkeypatch.setattr(link, "admit", admit)
    for name in ("\ud800", "x" * 100_000, ""):
        for sign_in in (both[0].sign_in, both[0].rapyuta.sign_in):
            with pytest.raises(TooManyAttempts):
                await sign_in(name, "password", "10.0.0.1")
    assert len(sent) == 6
    assert max(map(len, sent)) < 200


# -- the process that keeps the logins is away -------------------------------------------------------------------------


async def test_stored_tokens_work_while_the_logins_cannot_be_reached(both: list[Accounts], link: Link) -> None:
    token = await both[0].login("ann", PASSWORD)
    link.is_cut = True
    assert (await both[1].authenticate(token)).id == "ann"
    with pytest.raises(Unavailable):
        await both[1].login("ann", PASSWORD)
    with pytest.raises(Unavailable):
        await both[1].authenticate("unknown, or kept in memory")


@pytest.mark.parametrize("change", ["a new password", "the end of all sessions", "a removed user"])
async def test_a_change_that_cannot_reach_kept_tokens_changes_nothing(
    both: list[Accounts], link: Link, store: FullStore, change: str
) -> None:
    token = await both[0].login("ann", PASSWORD)
    before = store.user("ann")
    link.is_cut = True
    with pytest.raises(Unavailable):
        await CHANGES[change](both[0], token)
    assert store.user("ann") == before
    link.is_cut = False
    assert (await both[0].authenticate(token)).id == "ann"
    await CHANGES[change](both[0], token)
    with pytest.raises(NotAuthenticated):
        await both[1].authenticate(token)


async def test_an_endpoint_that_is_not_told_refuses_a_revoked_token_soon(
    both: list[Accounts], link: Link, clock: ManualClock, caplog: pytest.LogCaptureFixture
) -> None:
    first, second = both
    token = await first.login("ann", PASSWORD)
    await second.authenticate(token)
    link.is_cut = True
    await first.revoke("ann", token_id(token))
    assert "other endpoints follow the changes of user 'ann' later" in caplog.text
    link.is_cut = False
    clock.advance(LIFETIME)
    with pytest.raises(NotAuthenticated):
        await second.authenticate(token)


async def test_an_endpoint_that_may_have_missed_changes_reads_all_users_again(both: list[Accounts], link: Link) -> None:
    first, second = both
    token = await first.login("ann", PASSWORD)
    await second.authenticate(token)
    link.is_cut = True
    await first.revoke("ann", token_id(token))
    link.is_cut = False
    second.forget_all()
    with pytest.raises(NotAuthenticated):
        await second.authenticate(token)


@pytest.mark.parametrize("away", ["link", "store"])
async def test_a_token_that_is_known_to_be_revoked_is_not_accepted_when_something_is_unreachable(
    both: list[Accounts], link: Link, store: FullStore, clock: ManualClock, monkeypatch: pytest.MonkeyPatch, away: str
) -> None:
    def unreachable(_hash: str) -> NoReturn:
        raise Unavailable("no node answers")

    first, second = both
    token = await first.login("ann", PASSWORD)
    await second.authenticate(token)
    link.is_cut = True
    await first.revoke("ann", token_id(token))
    clock.advance(LIFETIME)
    if away == "store":
        link.is_cut = False
        with contextlib.suppress(NotAuthenticated):
            await second.authenticate(token)
        monkeypatch.setattr(store, "token", unreachable)
    for _ in range(2):
        with pytest.raises(Unavailable):
            await second.authenticate(token)


async def test_all_listeners_drop_what_they_know_of_a_user_also_if_one_fails() -> None:
    def fail(user: str) -> None:
        raise ZeroDivisionError

    logins, forgotten = LocalLogins(), list[str]()
    logins.on_forget(fail)
    logins.on_forget(forgotten.append)
    await logins.forget("ann")
    assert forgotten == ["ann"]


REVOCATIONS = {name: CHANGES[name] for name in ("a revoked token", "the end of all sessions")}


@pytest.mark.parametrize("change", REVOCATIONS)
async def test_a_token_that_cannot_be_removed_yet_is_refused_everywhere_and_removed_later(
    both: list[Accounts], store: FullStore, change: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = both
    first._tokens._revocations._retry = 0.01
    token, other = await first.login("ann", PASSWORD), await first.login("ann", PASSWORD)
    for accounts in both:
        await accounts.authenticate(token)
    store.keeps_tokens = True
    await REVOCATIONS[change](first, token)
    for accounts in both:
        with pytest.raises(NotAuthenticated):
            await accounts.authenticate(token)
    if change == "a revoked token":
        assert (await second.authenticate(other)).id == "ann"
    assert token_id(token) in [one.hash for one in store.tokens("ann")]
    store.keeps_tokens = False
    await until(lambda: token_id(token) not in [one.hash for one in store.tokens("ann")])
    await until(lambda: not first._tokens._revocations._refused)
    with pytest.raises(NotAuthenticated):
        await second.authenticate(token)


async def test_a_revoked_token_is_refused_also_where_it_is_removed_while_it_is_read(
    both: list[Accounts], store: FullStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    def read_slowly(user_id: str) -> User:
        found.set()
        assert removed.wait(30.0)
        return MemoryStore.user(store, user_id)

    first, second = both
    first._tokens._revocations._retry = 0.01
    token = await first.login("ann", PASSWORD)
    store.keeps_tokens = True
    await first.revoke("ann", token_id(token))
    found, removed = threading.Event(), threading.Event()
    monkeypatch.setattr(store, "user", read_slowly)
    reading = asyncio.create_task(second.authenticate(token))
    await until(found.is_set)
    store.keeps_tokens = False
    await until(lambda: not first._tokens._revocations._refused)
    removed.set()
    with pytest.raises(NotAuthenticated):
        await reading


async def test_the_next_master_learns_the_tokens_that_are_refused(both: list[Accounts], store: FullStore) -> None:
    first, second = both
    first._tokens._revocations._retry = 0.01
    token = await first.login("ann", PASSWORD)
    store.keeps_tokens = True
    await first.revoke("ann", token_id(token))
    next_master = LocalLogins()
    for accounts in both:
        accounts._logins = accounts._tokens._logins = accounts._tokens._revocations._logins = next_master
    await until(lambda: next_master._refused)
    with pytest.raises(NotAuthenticated):
        await second.authenticate(token)
    store.keeps_tokens = False
    await until(lambda: not next_master._refused)


async def test_a_token_is_refused_also_while_the_store_cannot_even_be_read(
    both: list[Accounts], store: FullStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unreachable(_hash: str) -> NoReturn:
        raise Unavailable("no node answers")

    first, second = both
    token = await first.login("ann", PASSWORD)
    await second.authenticate(token)
    with monkeypatch.context() as patch:
        patch.setattr(store, "token", unreachable)
        await first.revoke("ann", token_id(token))
        for accounts in both:
            with pytest.raises(Unavailable):
                await accounts.authenticate(token)
    for accounts in both:
        with pytest.raises(NotAuthenticated):
            await accounts.authenticate(token)


async def test_only_the_own_tokens_of_a_user_are_refused(
    both: list[Accounts], store: FullStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unreachable(_hash: str) -> NoReturn:
        raise Unavailable("no node answers")

    first = both[0]
    await first.register("bob", PASSWORD)
    token = await first.login("ann", PASSWORD)
    with monkeypatch.context() as patch:
        patch.setattr(store, "token", unreachable)
        await first.revoke("bob", token_id(token))
    assert (await first.authenticate(token)).id == "ann"


async def test_a_revocation_that_neither_the_store_nor_the_others_learn_of_fails(
    both: list[Accounts], store: FullStore, link: Link
) -> None:
    first = both[0]
    token = await first.login("ann", PASSWORD)
    store.keeps_tokens = link.is_cut = True
    with pytest.raises(Unavailable):
        await first.revoke("ann", token_id(token))
    with pytest.raises(NotAuthenticated):
        await first.authenticate(token)
