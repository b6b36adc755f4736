"""Passwords of users for robots that log in by the protocol of Rapyuta, which sends the SHA-256 hash of a password.

To a reader of the network, that hash is as good as the password, and the stored hashes of the users' passwords
cannot be compared with it. So an administrator sets another password for the robots of a user. It opens nothing but
this protocol, and it is stored as the argon2id hash of the SHA-256 hash.
"""

import hashlib
import logging

import msgspec
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.passwords import Passwords
from endpoints.accounts.shared_logins import SharedLogins
from endpoints.accounts.tokens import Tokens
from endpoints.accounts.user_lookup import counted_name, find_user
from endpoints.accounts.user_turns import UserTurns, in_turn
from ppaas.errors import Conflict, InvalidInput, NotAuthenticated, NotFound
from storage.ports import UserStore
from storage.records import User

logger = logging.getLogger(__name__)


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
