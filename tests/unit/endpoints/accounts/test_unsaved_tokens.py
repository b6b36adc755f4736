"""Logins while the store refuses writes: an administrator must be able to log in and free space."""

from typing import Any

import pytest

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.accounts.token_cache import TokenCache
from endpoints.accounts.unsaved_tokens import MAX_UNSAVED, UNSAVED_LIFETIME, UnsavedTokens
from ppaas.clock import ManualClock
from ppaas.errors import NotAuthenticated, NotFound, Unavailable
from storage.memory.store import MemoryStore
from storage.records import Token

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
