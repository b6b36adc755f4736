"""Password hashing with argon2id in a bounded thread pool.

A hash takes tens of milliseconds of a core and 64 MiB by design. A few threads compute hashes, a limited number of
requests waits for them, and further requests are refused: a flood of logins blocks neither memory nor event loop.
"""

import asyncio
import functools
import logging
import os
import secrets
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError, VerifyMismatchError

from ppaas.errors import Unavailable

logger = logging.getLogger(__name__)

T = TypeVar("T")

WAITING = 64
"""Largest number of waiting requests."""

NICE = 10
"""Nice value of the hashing threads: logins must not delay commands of robots.

Such a thread gets a tenth of the CPU time of a container that competes for the same core. With 19, a seventieth, a
login took half a minute on a fully loaded computer, which is when its client times out.
"""


def _be_nice() -> None:
    os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICE)  # on Linux, of this thread only


class Passwords:
    """Hashes and verifies passwords.

    Parameters
    ----------
    hasher : argon2.PasswordHasher, optional
        Hasher; by default the low-memory profile of RFC 9106 with one lane, so that each worker uses one core.
    workers : int, optional
        Number of threads; by default the number of usable CPUs.
    waiting : int
        Number of further requests that may wait.
    """

    def __init__(
        self, hasher: PasswordHasher | None = None, workers: int | None = None, waiting: int = WAITING
    ) -> None:
        workers = workers or len(os.sched_getaffinity(0))
        self._hasher = hasher or PasswordHasher(parallelism=1)
        self._threads = ThreadPoolExecutor(workers, "argon2", _be_nice)
        self._slots = threading.BoundedSemaphore(workers + waiting)

    async def hash(self, password: str) -> str:
        """Return the hash of a password; ``Unavailable`` if too many requests wait."""
        return await self._run(lambda: self._hasher.hash(_bytes(password)))

    async def verify(self, password_hash: str | None, password: str) -> bool:
        """Return whether a password matches a hash; ``Unavailable`` if too many requests wait.

        Without a hash, because the user does not exist, it takes the same time and returns false.
        """
        matches = await self._run(lambda: self._verify(password_hash, password))
        return matches and password_hash is not None

    def close(self) -> None:
        """End the threads."""
        self._threads.shutdown(cancel_futures=True)

    @functools.cached_property
    def _dummy_hash(self) -> str:
        return self._hasher.hash(secrets.token_bytes(16))

    def _verify(self, password_hash: str | None, password: str) -> bool:
        dummy = self._dummy_hash  # computed also for existing users, so that timing reveals nothing
        try:
            return self._hasher.verify(password_hash or dummy, _bytes(password))
        except VerifyMismatchError:
            return False
        except (VerificationError, InvalidHashError):
            logger.exception("a stored password hash cannot be verified")
            return False

    async def _run(self, work: Callable[[], T]) -> T:
        if not self._slots.acquire(blocking=False):
            raise Unavailable("too many login attempts at once: try again in a moment")
        try:
            future = self._threads.submit(work)
        except BaseException:
            self._slots.release()
            raise
        # Released by the thread, not the caller: a cancelled request leaves its work running.
        future.add_done_callback(lambda _: self._slots.release())
        return await asyncio.wrap_future(future)


def _bytes(password: str) -> bytes:
    return password.encode("utf-8", "surrogatepass")
