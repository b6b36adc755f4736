"""Who may use the cloud: users, their passwords and the tokens they log in for."""

import hashlib
import logging
import secrets
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.passwords import Passwords
from endpoints.accounts.token_cache import TokenCache
from ppaas.clock import Clock, epoch
from ppaas.errors import Conflict, InvalidInput, NotAuthenticated, NotFound, NotPermitted, Unavailable
from storage.names import check_name, is_name
from storage.ports import UserStore
from storage.records import Role, Token, User

logger = logging.getLogger(__name__)

ADMIN = "admin"
ME = "me"
"""Whoever asks; nobody's name."""

TOKEN_LIFETIME = 30 * 24 * 3600.0
MIN_PASSWORD = 8
MAX_PASSWORD = 1024
MAX_TOKEN = 256
TOKEN_PREFIX = "ppaas_"
"""So that no token begins with a dash, which a command would take for an option, and lost ones can be searched for."""


@dataclass(frozen=True, slots=True)
class IssuedToken:
    """A token, when it expires [s since the epoch], and the id with which it is revoked."""

    token: str
    expires: float

    @property
    def id(self) -> str:
        """The hash, which is all that is kept."""
        return token_id(self.token)


class Accounts:
    """Registers users, logs them in and knows them by their tokens.

    A token is random and only its hash is kept, so that who reads the store can't be anybody. It is told only once.

    Parameters
    ----------
    store : UserStore
        Keeps users and tokens.
    clock : callable
        Seconds since the epoch.
    passwords : Passwords, optional
        Hashes them; closed with the accounts.
    lifetime : float
        How long a token is good for [s].
    cache : TokenCache, optional
        Of verified tokens.
    """

    def __init__(
        self,
        store: UserStore,
        clock: Clock = epoch,
        *,
        passwords: Passwords | None = None,
        lifetime: float = TOKEN_LIFETIME,
        cache: TokenCache | None = None,
    ) -> None:
        self._store = store
        self._clock = clock
        self._passwords = passwords or Passwords()
        self._lifetime = lifetime
        self._cache = cache or TokenCache()
        self._changing = threading.Lock()

    def close(self) -> None:
        """End the threads that hash passwords."""
        self._passwords.close()

    async def register(self, user_id: str, password: str, role: Role = "user") -> User:
        """Make a user.

        Raises
        ------
        InvalidInput
            The id is no name, or the password too short or too long.
        Conflict
            The id is taken.
        Unavailable
            Too many are logging in.
        """
        if check_name("user", user_id) == ME:
            raise InvalidInput(f"{ME!r} is whoever asks: take another id")
        _check_password(password)
        user = User(user_id, await self._passwords.hash(password), role)
        await run_in_threadpool(self._store.add_user, user)
        return user

    async def ensure_admin(self, password: str) -> User:
        """Return the user ``admin``, made with this password if there is none; one who is there keeps the old one."""
        admin = await self._find(ADMIN)
        if admin is None:
            return await self.register(ADMIN, password, "admin")
        if admin.role != "admin":
            raise Conflict(f"the user {ADMIN!r} exists and is no administrator: remove it first")
        return admin

    async def tell_if_other(self, user: User, password: str) -> None:
        """Say in the log where a user has another password than this one, which takes as long as a login."""
        if not await self._passwords.verify(user.password_hash, password):
            logger.warning("the user %r exists with another password, which it keeps", user.id)

    async def sign_in(self, user_id: str, password: str) -> IssuedToken:
        """Give a new token to who knows the password.

        Raises
        ------
        NotAuthenticated
            There is no such user, or the password is another; which of the two is not told, nor seen by the time
            that it takes.
        Unavailable
            Too many are logging in.
        """
        user = await self._find(user_id)
        if not await self._passwords.verify(user.password_hash if user else None, password) or user is None:
            raise NotAuthenticated("wrong user or password")
        now = self._clock()
        login = IssuedToken(f"{TOKEN_PREFIX}{secrets.token_urlsafe(32)}", now + self._lifetime)
        try:
            await run_in_threadpool(self._store.add_token, Token(login.id, user.id, login.expires, now))
        except NotFound as error:
            raise NotAuthenticated("wrong user or password") from error
        await run_in_threadpool(self._store.remove_tokens, expired_before=now)
        return login

    async def login(self, user_id: str, password: str) -> str:
        """Return a new token for who knows the password; raises as ``sign_in`` does."""
        return (await self.sign_in(user_id, password)).token

    async def authenticate(self, token: str) -> User:
        """Return the user of a token; ``NotAuthenticated`` if it is not one of ours, or expired.

        While the store is away, those it knew of late are known.
        """
        if not 0 < len(token) <= MAX_TOKEN:
            raise _unknown_token()
        token_hash, now = token_id(token), self._clock()
        known = self._cache.get(token_hash, now)
        if known is not None:
            return known
        forgotten = self._cache.forgotten
        try:
            kept, user = await run_in_threadpool(self._token_and_user, token_hash)
        except Unavailable:
            known = self._cache.last_known(token_hash, now)
            if known is None:
                raise
            return known
        if kept.expires <= now:
            raise _unknown_token()
        if self._cache.forgotten == forgotten:  # else what was read may have been removed meanwhile
            self._cache.put(token_hash, user, now, kept.expires)
        return user

    async def change(
        self,
        user_id: str,
        *,
        role: Role | None = None,
        password: str | None = None,
        keep_token: str | None = None,
        limits: Mapping[str, float | None] | None = None,
    ) -> User:
        """Give a user another role, password or limits; with the old password go all tokens but the one of this id.

        Of the limits, those that are not named stay, and None is what every user may have.

        Raises
        ------
        NotFound
            There is no such user.
        InvalidInput
            The password is too short or too long.
        """
        await run_in_threadpool(self._store.user, user_id)  # none is hashed for nobody
        changes: dict[str, Any] = {} if role is None else {"role": role}
        if password is not None:
            _check_password(password)
            changes["password_hash"] = await self._passwords.hash(password)
        try:
            return await run_in_threadpool(self._change, user_id, changes, limits or {}, keep_token)
        finally:
            self._cache.forget(user_id)

    async def check_password(self, user_id: str, password: str) -> None:
        """Raise ``NotPermitted`` unless this is the user's password."""
        user = await run_in_threadpool(self._store.user, user_id)
        if not await self._passwords.verify(user.password_hash, password):
            raise NotPermitted("old_password is not the password that this user has now")

    async def revoke(self, user_id: str, token: str) -> None:
        """Forget a token of a user by its id; ``NotFound`` if the user has none of it."""
        kept = await run_in_threadpool(self._store.token, token)
        if kept.user != user_id:
            raise NotFound("token", token)
        try:
            await run_in_threadpool(self._store.remove_token, token)
        finally:
            self._cache.forget(user_id)

    async def remove(self, user_id: str) -> None:
        """Forget a user with all that is the user's; ``NotFound`` if there is none."""
        try:
            await run_in_threadpool(self._store.remove_user, user_id)
        finally:
            self._cache.forget(user_id)

    async def _find(self, user_id: str) -> User | None:
        if not is_name(user_id):
            return None
        try:
            return await run_in_threadpool(self._store.user, user_id)
        except NotFound:
            return None

    def _change(
        self, user_id: str, changes: dict[str, Any], limits: Mapping[str, float | None], keep_token: str | None
    ) -> User:
        with self._changing:  # what two change at the same time is changed by both
            user = self._store.user(user_id)
            own = msgspec.structs.replace(user.limits, **limits)
            changed = msgspec.structs.replace(user, limits=own, **changes)
            self._store.change_user(changed, keep_token=keep_token)
        return changed

    def _token_and_user(self, token_hash: str) -> tuple[Token, User]:
        try:
            token = self._store.token(token_hash)
            return token, self._store.user(token.user)
        except NotFound as error:
            raise _unknown_token() from error


def token_id(token: str) -> str:
    """Return the hash under which a token is kept; nobody gets from it back to the token."""
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()


def _unknown_token() -> NotAuthenticated:
    return NotAuthenticated("the token is unknown or expired: log in again ('ppaas login', or POST /v1/tokens)")


def _check_password(password: str) -> None:
    if not MIN_PASSWORD <= len(password) <= MAX_PASSWORD:
        raise InvalidInput(f"a password has from {MIN_PASSWORD} to {MAX_PASSWORD} characters, not {len(password)}")
