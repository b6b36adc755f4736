"""Passwords as argon2id hashes, made beside the event loop and never too many at a time.

Each costs tens of milliseconds of a core and 64 MiB on purpose. So a few threads do it, a few requests may wait for
them, and who comes beyond that is told to try again: a flood of logins takes neither the memory nor the event loop.
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

NICE = 10
"""Of the threads that hash: whoever logs in waits a little longer, so that no robot waits for its commands.

It is a tenth of what a container gets where both want a core. With 19, a seventieth, a login took half a minute on a
computer whose cores all were busy, and that is when its client gives up.
"""


def _be_nice() -> None:
    os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICE)  # on Linux, of this thread alone


class Passwords:
    """Hashes and verifies passwords.

    Parameters
    ----------
    hasher : argon2.PasswordHasher, optional
        With its parameters; without it, the low-memory profile of RFC 9106 on one lane, so that as many cores are
        taken as there are workers, and no more.
    workers : int, optional
        How many at a time; as many as there are CPUs to run on.
    waiting : int
        How many more may wait.
    """

    def __init__(
        self, hasher: PasswordHasher | None = None, workers: int | None = None, waiting: int = WAITING
    ) -> None:
        workers = workers or len(os.sched_getaffinity(0))
        self._hasher = hasher or PasswordHasher(parallelism=1)
        self._threads = ThreadPoolExecutor(workers, "argon2", _be_nice)
        self._room = threading.BoundedSemaphore(workers + waiting)

    async def hash(self, password: str) -> str:
        """Return the hash of a password; ``Unavailable`` if too many wait already."""
        return await self._run(lambda: self._hasher.hash(_bytes(password)))

    async def verify(self, password_hash: str | None, password: str) -> bool:
        """Tell whether a password is that of a hash; ``Unavailable`` if too many wait already.

        Without a hash, because there is no such user, it takes as long and the answer is no.
        """
        right = await self._run(lambda: self._verify(password_hash, password))
        return right and password_hash is not None

    def close(self) -> None:
        """End the threads."""
        self._threads.shutdown(cancel_futures=True)

    @functools.cached_property
    def _nobodys(self) -> str:
        return self._hasher.hash(secrets.token_bytes(16))

    def _verify(self, password_hash: str | None, password: str) -> bool:
        nobodys = self._nobodys  # whoever is first waits for it to be made, known or not
        try:
            return self._hasher.verify(password_hash or nobodys, _bytes(password))
        except VerifyMismatchError:
            return False
        except (VerificationError, InvalidHashError):
            logger.exception("a stored password hash cannot be verified")
            return False

    async def _run(self, work: Callable[[], T]) -> T:
        if not self._room.acquire(blocking=False):
            raise Unavailable("too many are logging in: try again in a moment")
        try:
            future = self._threads.submit(work)
        except BaseException:
            self._room.release()
            raise
        # Not when the caller has its answer: one who has gone away leaves the work behind.
        future.add_done_callback(lambda _: self._room.release())
        return await asyncio.wrap_future(future)


def _bytes(password: str) -> bytes:
    return password.encode("utf-8", "surrogatepass")
