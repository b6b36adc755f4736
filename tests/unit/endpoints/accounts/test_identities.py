"""Users of an identity provider: two logins at once, and removals meanwhile."""

import asyncio

import pytest

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.identities import PAGE
from endpoints.accounts.passwords import Passwords
from ppaas.clock import ManualClock
from ppaas.errors import Conflict, NotAuthenticated, NotFound
from storage.memory.store import MemoryStore
from storage.records import User
from storage.sharing_records import ProvidedIdentity

ANN, OTHER = ProvidedIdentity("https://login.example", "1"), ProvidedIdentity("https://evil.example", "1")


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


@pytest.fixture
def accounts(store: MemoryStore, clock: ManualClock, passwords: Passwords) -> Accounts:
    return Accounts(store, clock, passwords=passwords)


async def test_two_first_logins_at_once_make_one_user(accounts: Accounts, store: MemoryStore) -> None:
    assert await accounts.identities.find(ANN, "ann") is None
    made = await asyncio.gather(*(accounts.identities.create(ANN, "ann", "user") for _ in range(4)))
    assert {user.id for user in made} == {"ann"} and len(store.users()) == 1


async def test_two_people_who_want_one_name_at_once_do_not_share_a_user(accounts: Accounts) -> None:
    made = await asyncio.gather(
        accounts.identities.create(ANN, "ann", "user"),
        accounts.identities.create(OTHER, "ann", "admin"),
        return_exceptions=True,
    )
    assert {type(one) for one in made} == {User, Conflict}


async def test_the_same_subject_of_another_issuer_is_somebody_else(accounts: Accounts) -> None:
    await accounts.identities.create(ANN, "ann", "user")
    with pytest.raises(Conflict):
        await accounts.identities.find(OTHER, "ann")
    assert await accounts.identities.find(OTHER, "ann2") is None


async def test_an_identity_is_found_among_many_users(accounts: Accounts, store: MemoryStore) -> None:
    for number in range(PAGE + 1):
        store.add_user(User(f"user{number:04}", "x"))
    made = await accounts.identities.create(ANN, "zoe", "user")
    assert await accounts.identities.find(ANN, "renamed") == made


async def test_a_user_who_is_removed_gets_no_token(accounts: Accounts) -> None:
    user = await accounts.identities.create(ANN, "ann", "user")
    await accounts.begin_removal("ann")
    with pytest.raises(NotAuthenticated):
        await accounts.identities.sign_in(user, "user", 60.0)
    await accounts.remove("ann")
    with pytest.raises(NotAuthenticated):
        await accounts.identities.sign_in(user, "admin", 60.0)


async def test_a_link_that_ends_during_a_login_gives_no_token(accounts: Accounts) -> None:
    user = await accounts.identities.create(ANN, "ann", "user")
    await accounts.identities.link("ann", None)
    with pytest.raises(NotAuthenticated, match="no longer yours"):
        await accounts.identities.sign_in(user, "admin", 60.0)


async def test_an_unknown_user_is_not_linked(accounts: Accounts) -> None:
    with pytest.raises(NotFound):
        await accounts.identities.link("nobody", ANN)
