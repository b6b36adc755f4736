"""Password hashing in threads."""

import asyncio
import threading

import pytest
from argon2 import PasswordHasher, profiles

from endpoints.accounts.passwords import Passwords
from ppaas.errors import Unavailable

PASSWORD = "correct horse"


class SlowHasher(PasswordHasher):
    """Blocks until the test releases it, and counts concurrent calls."""

    def __init__(self) -> None:
        cheap = profiles.CHEAPEST
        super().__init__(cheap.time_cost, cheap.memory_cost, cheap.parallelism)
        self.go_on = threading.Event()
        self.at_it = 0
        self.most = 0
        self._lock = threading.Lock()

    def verify(self, hash: str | bytes, password: str | bytes) -> bool:  # noqa: A002
        with self._lock:
            self.at_it += 1
            self.most = max(self.most, self.at_it)
        assert self.go_on.wait(30.0)
        with self._lock:
            self.at_it -= 1
        return super().verify(hash, password)


async def test_beyond_the_workers_and_those_who_wait_logins_are_refused_and_then_go_on() -> None:
    hasher = SlowHasher()
    passwords = Passwords(hasher, workers=2, waiting=3)
    right = hasher.hash(PASSWORD)
    waiting = [asyncio.create_task(passwords.verify(right, PASSWORD)) for _ in range(5)]
    await asyncio.sleep(0)
    with pytest.raises(Unavailable, match="too many"):
        await passwords.verify(right, PASSWORD)
    hasher.go_on.set()
    assert await asyncio.gather(*waiting) == [True] * 5
    assert hasher.most <= 2
    assert await passwords.verify(right, "wrong password") is False
    passwords.close()


async def test_who_goes_away_while_waiting_makes_room() -> None:
    hasher = SlowHasher()
    passwords = Passwords(hasher, workers=1, waiting=1)
    right = hasher.hash(PASSWORD)
    first, second = (asyncio.create_task(passwords.verify(right, PASSWORD)) for _ in range(2))
    await asyncio.sleep(0)
    second.cancel()
    await asyncio.wait({second})
    third = asyncio.create_task(passwords.verify(right, PASSWORD))
    await asyncio.sleep(0)
    hasher.go_on.set()
    assert await asyncio.gather(first, third) == [True, True]
    passwords.close()
