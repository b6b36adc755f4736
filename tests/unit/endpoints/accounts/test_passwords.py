"""Password hashing in threads."""

import asyncio
import hashlib
import threading
import time
from collections.abc import Callable

import pytest
from argon2 import Parameters, PasswordHasher, extract_parameters, profiles

from endpoints.accounts import passwords as module
from endpoints.accounts.fair_queue import RequestOrigin
from endpoints.accounts.passwords import Passwords
from endpoints.resources.services import Services
from ppaas.errors import Conflict, InvalidInput, NotAuthenticated, NotFound, TooManyAttempts, Unavailable

PASSWORD = "correct horse"


class SlowHasher(PasswordHasher):
    """Blocks until the test releases it, and counts concurrent calls."""

    def __init__(self) -> None:
        cheap = profiles.CHEAPEST
        super().__init__(cheap.time_cost, cheap.memory_cost, cheap.parallelism)
        self.released = threading.Event()
        self.active = 0
        self.max_active = 0
        self._lock = threading.Lock()

    def verify(self, hash: str | bytes, password: str | bytes) -> bool:  # noqa: A002
        with self._lock:
            self.active += 1
            self.max_active = max(self.max_active, self.active)
        assert self.released.wait(30.0)
        with self._lock:
            self.active -= 1
        return super().verify(hash, password)


async def test_logins_beyond_workers_and_queue_are_refused() -> None:
    hasher = SlowHasher()
    passwords = Passwords(hasher, workers=2, waiting=3)
    right = hasher.hash(PASSWORD)
    waiting = [asyncio.create_task(passwords.verify(right, PASSWORD)) for _ in range(5)]
    await asyncio.sleep(0)
    with pytest.raises(Unavailable, match="too many"):
        await passwords.verify(right, PASSWORD)
    hasher.released.set()
    assert await asyncio.gather(*waiting) == [True] * 5
    assert hasher.max_active <= 2
    assert await passwords.verify(right, "wrong password") is False
    passwords.close()


@pytest.mark.parametrize("profile", [profiles.CHEAPEST, profiles.PRE_21_2])
async def test_the_password_of_an_unknown_user_is_compared_at_the_cost_of_any_other(
    profile: Parameters,
) -> None:
    compared = []

    class Hasher(PasswordHasher):
        def verify(self, hash: str | bytes, password: str | bytes) -> bool:  # noqa: A002
            compared.append(extract_parameters(str(hash)))
            return super().verify(hash, password)

    passwords = Passwords(Hasher.from_parameters(profile), workers=1)
    for known in (None, await passwords.hash(PASSWORD)):
        assert await passwords.verify(known, "wrong password") is False
    assert compared == [profile, profile]
    passwords.close()


async def test_cancelling_a_queued_login_frees_its_slot() -> None:
    hasher = SlowHasher()
    passwords = Passwords(hasher, workers=1, waiting=1)
    right = hasher.hash(PASSWORD)
    first, second = (asyncio.create_task(passwords.verify(right, PASSWORD)) for _ in range(2))
    await asyncio.sleep(0)
    second.cancel()
    await asyncio.wait({second})
    third = asyncio.create_task(passwords.verify(right, PASSWORD))
    await asyncio.sleep(0)
    hasher.released.set()
    assert await asyncio.gather(first, third) == [True, True]
    passwords.close()


async def test_a_flood_from_one_address_does_not_keep_another_out() -> None:
    hasher = SlowHasher()
    passwords = Passwords(hasher, workers=1, waiting=3)
    right = hasher.hash(PASSWORD)
    flood = [
        asyncio.create_task(passwords.verify(None, "guess", RequestOrigin("nobody", "10.0.0.1"))) for _ in range(4)
    ]
    await asyncio.sleep(0)
    ann = asyncio.create_task(passwords.verify(right, PASSWORD, RequestOrigin("ann", "10.0.0.2")))
    await asyncio.sleep(0)
    hasher.released.set()
    assert await ann is True
    answers = await asyncio.gather(*flood, return_exceptions=True)
    assert [type(answer) for answer in answers] == [bool, bool, bool, Unavailable], "the newest of the flood is dropped"
    passwords.close()


def test_a_thread_is_free_again_if_the_loop_closes_right_after_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    call_on = module._call_on

    def call_late(loop: asyncio.AbstractEventLoop, function: Callable[[], None]) -> None:
        time.sleep(0.05)  # as a thread does that another process holds up
        call_on(loop, function)

    monkeypatch.setattr(module, "_call_on", call_late)
    passwords = Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=1)
    for _ in range(2):  # each on a loop of its own
        asyncio.run(asyncio.wait_for(passwords.hash(PASSWORD), 5.0))
    passwords.close()


OWN, ROBOTS = "correct horse", "battery staple"


def _digest(password: str) -> str:
    return hashlib.sha256(password.encode()).hexdigest()


@pytest.fixture
async def ann(services: Services) -> Services:
    """Return services with the user ann, whose robots have a password."""
    await services.accounts.register("ann", OWN)
    await services.accounts.rapyuta.set("ann", ROBOTS)
    return services


# Passwords for robots that log in by the protocol of Rapyuta.


async def test_the_hash_of_the_password_is_a_login_whose_token_nobody_knows(ann: Services) -> None:
    user, token = await ann.accounts.rapyuta.sign_in("ann", _digest(ROBOTS).upper(), "10.0.0.1")
    assert user.id == "ann"
    assert (await ann.accounts.user_of(token)).id == "ann"


async def test_neither_the_password_nor_its_hash_is_stored(ann: Services) -> None:
    stored = ann.store.user("ann").rapyuta_hash
    assert stored.startswith("$argon2id$")
    with pytest.raises(NotAuthenticated):
        await ann.accounts.rapyuta.sign_in("ann", stored)
    with pytest.raises(NotAuthenticated):
        await ann.accounts.rapyuta.sign_in("ann", ROBOTS)


@pytest.mark.parametrize(
    ("user", "password"), [("ann", OWN), ("ann", "guess"), ("bob", ROBOTS), ("no/name", ROBOTS), ("", "")]
)
async def test_other_hashes_and_users_are_no_login(ann: Services, user: str, password: str) -> None:
    with pytest.raises(NotAuthenticated, match="wrong user or password"):
        await ann.accounts.rapyuta.sign_in(user, _digest(password))


async def test_the_password_of_robots_opens_nothing_else(ann: Services) -> None:
    for password in (ROBOTS, _digest(ROBOTS)):
        with pytest.raises(NotAuthenticated):
            await ann.accounts.login("ann", password)


async def test_a_removed_password_is_no_login(ann: Services) -> None:
    assert (await ann.accounts.rapyuta.set("ann", None)).rapyuta_hash == ""
    with pytest.raises(NotAuthenticated):
        await ann.accounts.rapyuta.sign_in("ann", _digest(ROBOTS))


async def test_the_password_of_the_user_is_not_one_for_robots_nor_the_other_way_round(ann: Services) -> None:
    with pytest.raises(InvalidInput, match="must not be that of the user"):
        await ann.accounts.rapyuta.set("ann", OWN)
    with pytest.raises(InvalidInput, match="password for robots"):
        await ann.accounts.change("ann", password=ROBOTS)
    assert await ann.accounts.login("ann", OWN)
    await ann.accounts.change("ann", password="a third password")


async def test_administrators_and_unknown_users_get_none(ann: Services) -> None:
    await ann.accounts.register("root", OWN, "admin")
    with pytest.raises(Conflict, match="administrator"):
        await ann.accounts.rapyuta.set("root", ROBOTS)
    with pytest.raises(NotFound):
        await ann.accounts.rapyuta.set("bob", ROBOTS)


async def test_failed_logins_of_robots_wait_and_do_not_end_the_wait_of_others(ann: Services) -> None:
    for _ in range(10):
        with pytest.raises(NotAuthenticated):
            await ann.accounts.sign_in("ann", "guess", "10.0.0.1")
        with pytest.raises(NotAuthenticated):
            await ann.accounts.rapyuta.sign_in("ann", _digest("guess"), "10.0.0.2")
    with pytest.raises(TooManyAttempts):
        await ann.accounts.rapyuta.sign_in("ann", _digest(ROBOTS), "10.0.0.2")
    await ann.accounts.rapyuta.sign_in("ann", _digest(ROBOTS), "10.0.0.1")
    with pytest.raises(TooManyAttempts):
        await ann.accounts.sign_in("ann", "guess", "10.0.0.1")
