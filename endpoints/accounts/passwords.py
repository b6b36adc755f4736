"""Password hashing with argon2id in a bounded thread pool, and the passwords of Rapyuta robots.

A hash takes tens of milliseconds of a core and 64 MiB by design. A few threads compute hashes, and a limited number of
requests waits for them in a fair queue: a flood of logins blocks neither memory, nor event loop, nor other users.
"""

import asyncio
import base64
import contextlib
import hashlib
import logging
import os
import secrets
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import msgspec
from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError, VerifyMismatchError
from argon2.low_level import ARGON2_VERSION
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.fair_queue import FairQueue, RequestOrigin
from endpoints.accounts.shared_logins import SharedLogins
from endpoints.accounts.tokens import Tokens
from endpoints.accounts.user_lookup import counted_name, find_user
from endpoints.accounts.user_turns import UserTurns, in_turn
from ppaas.errors import Conflict, InvalidInput, NotAuthenticated, NotFound, Unavailable
from storage.ports import UserStore
from storage.records import User

logger = logging.getLogger(__name__)

T = TypeVar("T")

HERE = RequestOrigin()
"""Origin of hashes that this process computes for itself."""

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
    """Hashes and verifies passwords; for use on one event loop at a time.

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
        self._dummy_hash = _hash_of_nothing(self._hasher)
        self._threads = ThreadPoolExecutor(workers, "argon2", _be_nice)
        self._free = workers
        self._turns: FairQueue[asyncio.Future[None]] = FairQueue(waiting)

    async def hash(self, password: str, origin: RequestOrigin = HERE) -> str:
        """Return the hash of a password; ``Unavailable`` if too many requests of this address wait."""
        return await self._run(lambda: self._hasher.hash(_bytes(password)), origin)

    async def verify(self, password_hash: str | None, password: str, origin: RequestOrigin = HERE) -> bool:
        """Return whether a password matches a hash; ``Unavailable`` if too many requests of this address wait.

        Without a hash, because the user does not exist, it takes the same time and returns false.
        """
        matches = await self._run(lambda: self._verify(password_hash, password), origin)
        return matches and password_hash is not None

    def close(self) -> None:
        """End the threads."""
        self._threads.shutdown(cancel_futures=True)

    def _verify(self, password_hash: str | None, password: str) -> bool:
        try:
            return self._hasher.verify(password_hash or self._dummy_hash, _bytes(password))
        except VerifyMismatchError:
            return False
        except (VerificationError, InvalidHashError):
            logger.exception("a stored password hash cannot be verified")
            return False

    async def _run(self, work: Callable[[], T], origin: RequestOrigin) -> T:
        await self._wait_for_turn(origin)
        try:
            future = self._threads.submit(work)
        except BaseException:
            self._release()
            raise
        # Released by the thread, not the caller: a cancelled request leaves its work running. Released before the
        # caller gets its result: it may close the loop, and this thread would be counted as busy for ever.
        loop = asyncio.get_running_loop()
        future.add_done_callback(lambda _: _call_on(loop, self._release))
        return await asyncio.wrap_future(future)

    async def _wait_for_turn(self, origin: RequestOrigin) -> None:
        if self._free:
            self._free -= 1
            return
        turn: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        dropped = self._turns.push(origin, turn)
        if dropped is not None and not dropped.done():
            dropped.set_exception(Unavailable("too many login attempts at once: try again in a moment"))
        try:
            await turn
        except asyncio.CancelledError:
            if turn.done() and not turn.cancelled() and turn.exception() is None:
                self._release()  # it got its turn in the same iteration of the loop
            self._turns.discard(origin, turn)
            raise

    def _release(self) -> None:
        """Give the thread to the next request that still waits."""
        while (turn := self._turns.pop()) is not None:
            if not turn.done():
                turn.set_result(None)
                return
        self._free += 1


def _hash_of_nothing(hasher: PasswordHasher) -> str:
    """Return a hash that no password has. A comparison with it takes as long as with any other, and it costs nothing.

    Random bytes stand for salt and hash, in the encoding of argon2's reference implementation.
    """
    salt, digest = (
        base64.b64encode(secrets.token_bytes(length)).decode().rstrip("=")
        for length in (hasher.salt_len, hasher.hash_len)
    )
    cost = f"m={hasher.memory_cost},t={hasher.time_cost},p={hasher.parallelism}"
    return f"$argon2{hasher.type.name.lower()}$v={ARGON2_VERSION}${cost}${salt}${digest}"


def _call_on(loop: asyncio.AbstractEventLoop, function: Callable[[], None]) -> None:
    with contextlib.suppress(RuntimeError):  # the loop is closed, and nobody waits
        loop.call_soon_threadsafe(function)


def _bytes(password: str) -> bytes:
    return password.encode("utf-8", "surrogatepass")


# A robot of Rapyuta sends the SHA-256 hash of a password. To a reader of the network, that hash is as good as the
# password, and the stored hashes of the users' passwords cannot be compared with it. So an administrator sets another
# password for the robots of a user. It opens nothing but this protocol, and it is stored as the argon2id hash of the
# SHA-256 hash.


class RapyutaPasswords:
    """Passwords for robots of Rapyuta.

    Parameters
    ----------
    store : UserStore
        Store of users.
    passwords : Passwords
        Password hashing.
    tokens : Tokens
        Tokens of the users.
    logins : SharedLogins
        Throttle of these logins. They are counted apart from the others: a success here, with a hash that was read on
        the network, must not end the wait of somebody who guesses the user's own password.
    turns : UserTurns
        Turns in which a user is read and changed.
    """

    def __init__(
        self, store: UserStore, passwords: Passwords, *, tokens: Tokens, logins: SharedLogins, turns: UserTurns
    ) -> None:
        self._store = store
        self._passwords = passwords
        self._tokens = tokens
        self._logins = logins
        self._turns = turns

    async def sign_in(self, user_id: str, digest: str, address: str = "") -> tuple[User, str]:
        """Return a user, and the id of a new token.

        Parameters
        ----------
        user_id : str
        digest : str
            SHA-256 hash of the password, in hexadecimal digits.
        address : str
            Address of the robot, by which attempts are throttled.

        Raises
        ------
        NotAuthenticated
            The user does not exist, is an administrator, has no password for robots, or has another one; neither text
            nor response time reveals which.
        TooManyAttempts
            Too many of these logins of this user or from this address failed.
        Unavailable
            Too many passwords are being hashed.
        """
        origin = await self._logins.admit(counted_name(user_id), address, "rapyuta")
        user = await find_user(self._store, user_id)
        stored = user.rapyuta_hash if user is not None and user.role != "admin" else ""
        if not await self._passwords.verify(stored or None, digest.lower(), origin) or user is None:
            failures = await self._logins.failed(origin)
            logger.warning(
                "login of a robot of %.64r from %s failed (%d in a row)", user_id, address or "here", failures
            )
            raise NotAuthenticated("wrong user or password")
        await self._logins.succeeded(origin)
        try:
            return user, (await self._tokens.issue(user.id)).id
        except NotFound as error:
            raise NotAuthenticated("wrong user or password") from error

    async def set(self, user_id: str, password: str | None) -> User:
        """Set the password for the robots of a user, who is returned; None stops robots from logging in by one.

        Raises
        ------
        NotFound
            The user does not exist.
        Conflict
            The user is an administrator.
        InvalidInput
            It is the password of the user.
        """
        user = await run_in_threadpool(self._store.user, user_id)
        stored = ""
        if password is not None:
            if user.role == "admin":
                # The token of an administrator's robot would administer the cloud (ADR 0044).
                raise Conflict("robots of an administrator do not log in by the protocol of Rapyuta: create a user")
            if await self._passwords.verify(user.password_hash, password):
                raise InvalidInput(
                    "the password for robots must not be that of the user, as robots send its hash over the network"
                )
            stored = await self._passwords.hash(_digest(password))
        try:
            return await in_turn(self._turns, user_id, lambda _: self._replace(user_id, stored))
        finally:
            await self._tokens.forget(user_id)

    async def check_other(self, user_id: str, password: str) -> None:
        """Raise ``InvalidInput`` if a new password of a user is the one for the user's robots."""
        user = await find_user(self._store, user_id)
        if user is None or not user.rapyuta_hash:
            return
        if await self._passwords.verify(user.rapyuta_hash, _digest(password)):
            raise InvalidInput("this is the password for robots of this user, whose hash crosses the network")

    def _replace(self, user_id: str, stored: str) -> User:
        changed = msgspec.structs.replace(self._store.user(user_id), rapyuta_hash=stored)
        self._store.change_user(changed)
        return changed


def _digest(password: str) -> str:
    return hashlib.sha256(password.encode("utf-8", "surrogatepass")).hexdigest()
