"""Password hashing in threads."""

import asyncio
import threading
import time
from collections.abc import Callable

import pytest
from argon2 import Parameters, PasswordHasher, extract_parameters, profiles

from endpoints.accounts import passwords as module
from endpoints.accounts.fair_queue import Origin
from endpoints.accounts.passwords import Passwords
from ppaas.errors import Unavailable

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
    flood = [asyncio.create_task(passwords.verify(None, "guess", Origin("nobody", "10.0.0.1"))) for _ in range(4)]
    await asyncio.sleep(0)
    ann = asyncio.create_task(passwords.verify(right, PASSWORD, Origin("ann", "10.0.0.2")))
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
