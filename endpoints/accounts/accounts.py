"""Accounts: users, their passwords and their tokens."""

import contextlib
import hashlib
import logging
import secrets
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.fair_queue import Origin
from endpoints.accounts.login_throttle import LoginThrottle
from endpoints.accounts.passwords import Passwords
from endpoints.accounts.rapyuta_passwords import RapyutaPasswords
from endpoints.accounts.scoped_user import user_of_token
from endpoints.accounts.socket_tickets import SocketTickets
from endpoints.accounts.token_cache import TokenCache
from endpoints.accounts.unsaved_tokens import UNSAVED_LIFETIME, UnsavedTokens
from endpoints.accounts.user_lookup import find_user
from ppaas.clock import Clock, epoch
from ppaas.errors import Conflict, InvalidInput, NotAuthenticated, NotFound, NotPermitted, Unavailable
from storage.names import check_name
from storage.ports import UserStore
from storage.records import Role, Token, User
from storage.sharing_records import TokenScope

logger = logging.getLogger(__name__)

ADMIN = "admin"
ME = "me"
"""Alias of the calling user; no user may have this id."""

TOKEN_LIFETIME = 30 * 24 * 3600.0
"""Lifetime of a token [s]."""

MIN_PASSWORD = 8
MAX_PASSWORD = 1024
MAX_TOKEN = 256
TOKEN_PREFIX = "ppaas_"
"""Prefix of tokens: none starts with a dash like an option of a command, and leaked tokens can be found."""

Regroup = Callable[[tuple[str, ...]], tuple[str, ...]]
"""Takes the groups of a user, and returns the new ones."""


@dataclass(frozen=True, slots=True)
class IssuedToken:
    """New token and its expiry [s since the epoch]."""

    token: str
    expires: float

    @property
    def id(self) -> str:
        """Hash of the token, under which it is stored and revoked."""
        return token_id(self.token)


class Accounts:
    """Registers users, logs them in and authenticates their tokens.

    A token is random and only its hash is stored, so that a reader of the store cannot impersonate a user. Its text is
    returned only once.

    Parameters
    ----------
    store : UserStore
        Store of users and tokens.
    clock : callable
        Returns the time [s since the epoch].
    passwords : Passwords, optional
        Password hashing; closed with the accounts.
    lifetime : float
        Lifetime of a token [s].
    cache : TokenCache, optional
        Cache of verified tokens.
    throttle : LoginThrottle, optional
        Throttle of logins.

    Attributes
    ----------
    tickets : SocketTickets
        Tickets for the WebSockets of browsers.
    rapyuta : RapyutaPasswords
        Passwords of users for robots that log in by the protocol of Rapyuta.
    """

    def __init__(
        self,
        store: UserStore,
        clock: Clock = epoch,
        *,
        passwords: Passwords | None = None,
        lifetime: float = TOKEN_LIFETIME,
        cache: TokenCache | None = None,
        throttle: LoginThrottle | None = None,
    ) -> None:
        self._store = store
        self._clock = clock
        self._passwords = passwords or Passwords()
        self._lifetime = lifetime
        self._cache = cache or TokenCache()
        self._throttle = throttle or LoginThrottle()
        self.tickets = SocketTickets()
        self._changing = threading.Lock()
        self._unsaved = UnsavedTokens()
        self.rapyuta = RapyutaPasswords(
            store,
            self._passwords,
            lambda user: self._issue(user, clock()),
            self._cache.forget_user,
            lock=self._changing,
        )

    def close(self) -> None:
        """End the threads that hash passwords."""
        self._passwords.close()

    async def register(self, user_id: str, password: str, role: Role = "user", groups: tuple[str, ...] = ()) -> User:
        """Create a user.

        Raises
        ------
        InvalidInput
            The id is not a valid name, or the password is too short or too long.
        Conflict
            The id is taken.
        Unavailable
            Too many passwords are being hashed.
        """
        if check_name("user", user_id) == ME:
            raise InvalidInput(f"{ME!r} is reserved for the calling user: choose another id")
        _check_password(password)
        user = User(user_id, await self._passwords.hash(password), role, groups=groups)
        await run_in_threadpool(self._store.add_user, user)
        return user

    async def ensure_admin(self, password: str) -> User:
        """Return the user ``admin``, created with this password if missing; an existing user keeps its password."""
        admin = await find_user(self._store, ADMIN)
        if admin is None:
            return await self.register(ADMIN, password, "admin")
        if admin.role != "admin":
            raise Conflict(f"user {ADMIN!r} exists but is not an administrator: remove it first")
        return admin

    async def warn_if_different(self, user: User, password: str) -> None:
        """Log a warning if a user has a different password; this takes as long as a login."""
        if not await self._passwords.verify(user.password_hash, password):
            logger.warning("user %r exists with a different password and keeps it", user.id)

    async def sign_in(self, user_id: str, password: str, address: str = "") -> IssuedToken:
        """Return a new token for a user and password.

        Parameters
        ----------
        user_id, password : str
        address : str
            Address of the client, by which attempts are throttled.

        Raises
        ------
        NotAuthenticated
            The user does not exist or the password is wrong; neither text nor response time reveals which.
        TooManyAttempts
            Too many logins of this user or from this address failed.
        Unavailable
            Too many passwords are being hashed.
        """
        origin = self._throttle.admit(user_id, address)
        user = await find_user(self._store, user_id)
        if not await self._matches(user, password, origin) or user is None:
            raise NotAuthenticated("wrong user or password")
        now = self._clock()
        try:
            return await run_in_threadpool(self._issue, user.id, now)
        except NotFound as error:
            raise NotAuthenticated("wrong user or password") from error

    async def issue_scoped(self, user_id: str, scope: TokenScope, lifetime: float, name: str = "") -> IssuedToken:
        """Return a new token of a user for some robots only; ``NotFound`` if the user does not exist.

        Parameters
        ----------
        user_id : str
        scope : TokenScope
            Limit of its rights.
        lifetime : float
            Time after which it expires [s].
        name : str
            What it is for.

        Raises
        ------
        Unavailable
            The store takes nothing now.
        """
        now = self._clock()
        issued = IssuedToken(_new_text(), now + lifetime)
        await run_in_threadpool(self._store.add_token, Token(issued.id, user_id, issued.expires, now, scope, name))
        return issued

    def _issue(self, user_id: str, now: float) -> IssuedToken:
        """Return a new token, stored, or kept in memory for a while if the store takes nothing, as on a full disk."""
        text = _new_text()
        try:
            login = IssuedToken(text, now + self._lifetime)
            self._store.add_token(Token(login.id, user_id, login.expires, now))
        except Unavailable as error:
            login = IssuedToken(text, now + min(self._lifetime, UNSAVED_LIFETIME))
            self._unsaved.add(Token(login.id, user_id, login.expires, now))
            logger.warning("the token of user %r is kept in memory for %g s: %s", user_id, login.expires - now, error)
            return login
        with contextlib.suppress(Unavailable):  # a later login removes them
            self._store.remove_tokens(expired_before=now)
        return login

    async def login(self, user_id: str, password: str) -> str:
        """Return the text of a new token; raises as ``sign_in`` does."""
        return (await self.sign_in(user_id, password)).token

    async def authenticate(self, token: str) -> User:
        """Return the user of a token, a `ScopedUser` if it has a scope; ``NotAuthenticated`` if unknown or expired.

        While the store is unreachable, recently verified tokens are accepted.
        """
        return await self.user_of(received_token_id(token))

    async def user_of(self, token_hash: str) -> User:
        """Return the user of a token, given by its id; raises as ``authenticate`` does."""
        now = self._clock()
        return await self._cache.read(
            token_hash, now, lambda: run_in_threadpool(self._user_and_expiry, token_hash, now)
        )

    async def change(
        self,
        user_id: str,
        *,
        role: Role | None = None,
        password: str | None = None,
        keep_token: str | None = None,
        limits: Mapping[str, float | None] | None = None,
        regroup: Regroup | None = None,
    ) -> User:
        """Change role, password, limits or groups of a user; a new password revokes all tokens except ``keep_token``.

        Omitted limits stay unchanged; None restores the limit of all users. ``regroup`` is called with the groups of
        the user, and returns the new ones.

        Raises
        ------
        NotFound
            The user does not exist.
        InvalidInput
            The password is too short or too long.
        """
        await run_in_threadpool(self._store.user, user_id)  # raises before the password is hashed in vain
        changes: dict[str, Any] = {} if role is None else {"role": role}
        if password is not None:
            _check_password(password)
            await self.rapyuta.check_other(user_id, password)
            changes["password_hash"] = await self._passwords.hash(password)
        try:
            return await run_in_threadpool(self._change, user_id, changes, limits or {}, keep_token, regroup)
        finally:
            self._cache.forget_user(user_id)

    async def check_password(self, user_id: str, password: str, address: str = "") -> None:
        """Raise ``NotPermitted`` unless this is the user's password, ``TooManyAttempts`` as ``sign_in`` does."""
        origin = self._throttle.admit(user_id, address)
        if not await self._matches(await run_in_threadpool(self._store.user, user_id), password, origin):
            raise NotPermitted("old_password is not the current password of this user")

    async def _matches(self, user: User | None, password: str, origin: Origin) -> bool:
        """Return whether the password is right, and count the attempt."""
        if await self._passwords.verify(user.password_hash if user else None, password, origin):
            self._throttle.succeeded(origin)
            return True
        failures = self._throttle.failed(origin)
        logger.warning("login of %.64r from %s failed (%d in a row)", origin.user, origin.address or "here", failures)
        return False

    async def revoke(self, user_id: str, token: str) -> None:
        """Revoke a token of a user by its id; ``NotFound`` if the user has no such token."""
        stored = self._unsaved.find(token)
        if stored is None:
            stored = await run_in_threadpool(self._store.token, token)
        if stored.user != user_id:
            raise NotFound("token", token)
        try:
            if not self._unsaved.remove(token):
                await run_in_threadpool(self._store.remove_token, token)
        finally:
            self._cache.forget_user(user_id)

    async def revoke_all(self, user_id: str) -> None:
        """Revoke all tokens of a user; ``NotFound`` if the user does not exist."""
        await run_in_threadpool(self._store.user, user_id)
        try:
            await run_in_threadpool(self._remove_tokens, user_id)
        finally:
            self._cache.forget_user(user_id)

    def _remove_tokens(self, user_id: str) -> None:
        self._unsaved.remove_all(user_id)
        for token in self._store.tokens(user_id):
            with contextlib.suppress(NotFound):  # revoked or expired meanwhile
                self._store.remove_token(token.hash)

    async def remove(self, user_id: str) -> None:
        """Remove a user with tokens and robots; ``NotFound`` if the user does not exist."""
        try:
            await run_in_threadpool(self._store.remove_user, user_id)
            self._unsaved.remove_all(user_id)
        finally:
            self._cache.forget_user(user_id)

    async def is_known(self, user_id: str) -> bool:
        """Return whether a user exists; False also if the store is unreachable."""
        try:
            return await find_user(self._store, user_id) is not None
        except Unavailable:
            return False

    def _change(
        self,
        user_id: str,
        changes: dict[str, Any],
        limits: Mapping[str, float | None],
        keep_token: str | None,
        regroup: Regroup | None,
    ) -> User:
        with self._changing:  # serialises concurrent changes, so that none is lost
            user = self._store.user(user_id)
            own = msgspec.structs.replace(user.limits, **limits)
            groups = user.groups if regroup is None else regroup(user.groups)
            changed = msgspec.structs.replace(user, limits=own, groups=groups, **changes)
            self._store.change_user(changed, keep_token=keep_token)
        if changed.password_hash != user.password_hash:
            self._unsaved.remove_all(user_id, keep=keep_token)
        return changed

    def _user_and_expiry(self, token_hash: str, now: float) -> tuple[User, float]:
        try:
            token = self._unsaved.find(token_hash) or self._store.token(token_hash)
            user = self._store.user(token.user)
        except NotFound as error:
            raise _unknown_token() from error
        if token.expires <= now:
            raise _unknown_token()
        return user_of_token(user, token), token.expires


def _new_text() -> str:
    return f"{TOKEN_PREFIX}{secrets.token_urlsafe(32)}"


def token_id(token: str) -> str:
    """Return the SHA-256 hash of a token, under which it is stored."""
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()


def received_token_id(token: str) -> str:
    """Return the id of a token that a client sent; ``NotAuthenticated`` if no token is this short or long."""
    if not 0 < len(token) <= MAX_TOKEN:
        raise _unknown_token()
    return token_id(token)


def _unknown_token() -> NotAuthenticated:
    return NotAuthenticated("the token is unknown or expired: log in again ('ppaas login', or POST /v1/tokens)")


def _check_password(password: str) -> None:
    if not MIN_PASSWORD <= len(password) <= MAX_PASSWORD:
        raise InvalidInput(f"a password must have {MIN_PASSWORD} to {MAX_PASSWORD} characters, not {len(password)}")
