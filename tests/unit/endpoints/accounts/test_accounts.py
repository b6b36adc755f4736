"""Users, passwords and tokens."""

import hashlib

import pytest
from argon2 import PasswordHasher

from endpoints.accounts.accounts import MAX_PASSWORD, Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.accounts.tokens import TOKEN_LIFETIME, TokenCache
from ppaas.clock import ManualClock
from ppaas.errors import Conflict, InvalidInput, NotAuthenticated, NotFound, Unavailable
from storage.memory.store import MemoryStore
from storage.records import Token, User

PASSWORD = "correct horse"


class CountingStore(MemoryStore):
    def __init__(self) -> None:
        super().__init__()
        self.looked_up = 0

    def token(self, token_hash: str) -> Token:
        self.looked_up += 1
        return super().token(token_hash)


@pytest.fixture
def store() -> CountingStore:
    return CountingStore()


@pytest.fixture
def accounts(store: CountingStore, clock: ManualClock, passwords: Passwords) -> Accounts:
    return Accounts(store, clock, passwords=passwords, cache=TokenCache(size=2, lifetime=30.0))


async def test_tokens_start_with_the_ppaas_prefix(accounts: Accounts, monkeypatch: pytest.MonkeyPatch) -> None:
    await accounts.register("ann", PASSWORD)
    monkeypatch.setattr("secrets.token_urlsafe", lambda length: "-" * length)
    assert (await accounts.login("ann", PASSWORD)).startswith("ppaas_")


async def test_login_returns_a_token_that_authenticates_the_user(accounts: Accounts) -> None:
    ann = await accounts.register("ann", PASSWORD)
    assert await accounts.authenticate(await accounts.login("ann", PASSWORD)) == ann


async def test_each_login_has_its_own_token(accounts: Accounts) -> None:
    await accounts.register("ann", PASSWORD)
    first, second = await accounts.login("ann", PASSWORD), await accounts.login("ann", PASSWORD)
    assert first != second
    assert await accounts.authenticate(first) == await accounts.authenticate(second)


async def test_passwords_and_tokens_are_stored_as_hashes(accounts: Accounts, store: MemoryStore) -> None:
    await accounts.register("ann", PASSWORD)
    token = await accounts.login("ann", PASSWORD)
    assert store.user("ann").password_hash.startswith("$argon2id$")
    assert store.token(hashlib.sha256(token.encode()).hexdigest()).user == "ann"
    assert len(token) >= 43


@pytest.mark.parametrize("user", ["ann", "bob", "", "../etc", "\ud800"])
async def test_unknown_user_and_wrong_password_give_the_same_error(accounts: Accounts, user: str) -> None:
    await accounts.register("ann", PASSWORD)
    with pytest.raises(NotAuthenticated, match=r"^wrong user or password$"):
        await accounts.login(user, "wrong password \ud800")


async def test_login_of_an_unknown_user_verifies_a_hash_of_equal_cost(
    accounts: Accounts, passwords: Passwords, monkeypatch: pytest.MonkeyPatch
) -> None:
    await accounts.register("ann", PASSWORD)
    parameters = []
    verify = PasswordHasher.verify

    def watched(hasher: PasswordHasher, password_hash: str, password: bytes) -> bool:
        parameters.append(password_hash.split("$")[:4])
        return verify(hasher, password_hash, password)

    monkeypatch.setattr(PasswordHasher, "verify", watched)
    for user in ("ann", "bob", "not a name"):
        with pytest.raises(NotAuthenticated):
            await accounts.login(user, "wrong password")
    assert len(parameters) == 3
    assert parameters[0] == parameters[1] == parameters[2]


async def test_a_token_expires(accounts: Accounts, clock: ManualClock) -> None:
    await accounts.register("ann", PASSWORD)
    login = await accounts.sign_in("ann", PASSWORD)
    assert login.expires == clock.now + TOKEN_LIFETIME
    clock.advance(TOKEN_LIFETIME - 1.0)
    assert (await accounts.authenticate(login.token)).id == "ann"
    clock.advance(1.0)
    with pytest.raises(NotAuthenticated, match="log in again"):
        await accounts.authenticate(login.token)


async def test_login_removes_expired_tokens(accounts: Accounts, store: MemoryStore, clock: ManualClock) -> None:
    await accounts.register("ann", PASSWORD)
    old = await accounts.login("ann", PASSWORD)
    clock.advance(TOKEN_LIFETIME + 1.0)
    await accounts.login("ann", PASSWORD)
    with pytest.raises(NotFound):
        store.token(hashlib.sha256(old.encode()).hexdigest())


@pytest.mark.parametrize("token", ["", "x", "x" * 10_000, "\ud800", "ä"])
async def test_malformed_tokens_are_refused(accounts: Accounts, token: str) -> None:
    with pytest.raises(NotAuthenticated):
        await accounts.authenticate(token)


async def test_verified_tokens_are_cached_for_a_limited_time(
    accounts: Accounts, store: CountingStore, clock: ManualClock
) -> None:
    await accounts.register("ann", PASSWORD)
    token = await accounts.login("ann", PASSWORD)
    for _ in range(5):
        await accounts.authenticate(token)
    assert store.looked_up == 1
    clock.advance(30.0)
    await accounts.authenticate(token)
    assert store.looked_up == 2


async def test_the_cache_evicts_the_least_recently_used_token(accounts: Accounts, store: CountingStore) -> None:
    await accounts.register("ann", PASSWORD)
    first, second, third = [await accounts.login("ann", PASSWORD) for _ in range(3)]
    for token in (first, second, first, third, first):
        await accounts.authenticate(token)
    assert store.looked_up == 3
    await accounts.authenticate(second)
    assert store.looked_up == 4


async def test_tokens_of_a_removed_user_are_refused_at_once(accounts: Accounts) -> None:
    await accounts.register("ann", PASSWORD)
    token = await accounts.login("ann", PASSWORD)
    await accounts.authenticate(token)
    await accounts.remove("ann")
    with pytest.raises(NotAuthenticated):
        await accounts.authenticate(token)
    with pytest.raises(NotFound):
        await accounts.remove("ann")


@pytest.mark.parametrize("password", ["", "1234567", "x" * (MAX_PASSWORD + 1)])
async def test_passwords_of_invalid_length_are_refused(accounts: Accounts, store: MemoryStore, password: str) -> None:
    with pytest.raises(InvalidInput, match="must have 8 to 1024 characters"):
        await accounts.register("ann", password)
    assert store.users() == []


async def test_registering_a_taken_id_conflicts_and_keeps_the_password(accounts: Accounts) -> None:
    await accounts.register("ann", PASSWORD)
    with pytest.raises(Conflict):
        await accounts.register("ann", "another password")
    await accounts.login("ann", PASSWORD)


async def test_ensure_admin_creates_the_admin_once_and_keeps_its_password(
    accounts: Accounts, caplog: pytest.LogCaptureFixture
) -> None:
    admin = await accounts.ensure_admin(PASSWORD)
    assert admin.role == "admin"
    assert await accounts.ensure_admin("another password") == admin
    await accounts.warn_if_different(admin, PASSWORD)
    assert caplog.records == []
    await accounts.warn_if_different(admin, "another password")
    assert "exists with a different password" in caplog.text
    assert "another password'" not in caplog.text
    await accounts.login("admin", PASSWORD)


async def test_ensure_admin_refuses_an_admin_user_without_the_role(accounts: Accounts) -> None:
    await accounts.register("admin", PASSWORD)
    with pytest.raises(Conflict, match="not an administrator"):
        await accounts.ensure_admin(PASSWORD)


async def test_login_with_a_damaged_hash_is_refused_and_logged(
    accounts: Accounts, store: MemoryStore, caplog: pytest.LogCaptureFixture
) -> None:
    store.add_user(User("ann", "not a hash"))
    with pytest.raises(NotAuthenticated):
        await accounts.login("ann", PASSWORD)
    assert "hash cannot be verified" in caplog.text


async def test_cached_users_authenticate_while_the_store_is_unreachable(
    accounts: Accounts, store: CountingStore, clock: ManualClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    ann = await accounts.register("ann", PASSWORD)
    known, unused = await accounts.login("ann", PASSWORD), await accounts.login("ann", PASSWORD)
    await accounts.authenticate(known)
    queries = 0

    def unreachable(_hash: str) -> Token:
        nonlocal queries
        queries += 1
        raise Unavailable("no node answers")

    monkeypatch.setattr(store, "token", unreachable)
    clock.now += 31.0
    for _ in range(3):
        assert await accounts.authenticate(known) == ann
    assert queries == 1, "the store is not queried each time"
    with pytest.raises(Unavailable):
        await accounts.authenticate(unused)
    clock.now += 25 * 3600.0
    with pytest.raises(Unavailable):
        await accounts.authenticate(known)
    monkeypatch.undo()
    await accounts.remove("ann")
    monkeypatch.setattr(store, "token", unreachable)
    with pytest.raises(Unavailable):
        await accounts.authenticate(known)
