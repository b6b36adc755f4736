"""Tokens of users: issued, found and revoked, over all endpoints of a cloud.

A revocation holds in the whole cloud at once, also where the store cannot be written yet.
"""

import asyncio
import contextlib
import hashlib
import logging
import secrets
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import msgspec
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.shared_logins import UNSAVED_LIFETIME, SharedLogins
from ppaas.clock import Clock
from ppaas.errors import NotAuthenticated, NotFound, Unavailable
from storage.disk_space import RefusedToken
from storage.ports import UserStore
from storage.records import Token, User
from storage.sharing_records import TokenScope
from storage.store_cache import StoreCache

logger = logging.getLogger(__name__)

# Revocations, which hold at once also where the store cannot be written yet.

RETRY = 2.0
"""Time between two attempts to remove a revoked token from the store [s]."""


class Revocations:
    """Removes tokens from the store; those that it cannot remove now are refused until it could.

    Parameters
    ----------
    store : UserStore
    logins : SharedLogins
        Where all endpoints of the cloud look for refused tokens.
    retry : float
        Time between two attempts [s].
    """

    def __init__(self, store: UserStore, logins: SharedLogins, retry: float = RETRY) -> None:
        self._store = store
        self._logins = logins
        self._retry = retry
        self._refused: dict[tuple[str, str], asyncio.Task[None]] = {}

    async def remove(self, user_id: str, token_hash: str) -> None:
        """Remove a token of a user from the store, or refuse it until it is removed.

        Raises
        ------
        NotFound
            The store has no such token.
        Unavailable
            The revocation is not kept; see `refuse`.
        """
        try:
            await run_in_threadpool(self._remove, user_id, token_hash)
        except Unavailable as error:
            await self.refuse(user_id, token_hash)
            logger.warning("a token of user %r is refused, and removed from the store later: %s", user_id, error)

    async def refuse(self, user_id: str, token_hash: str) -> None:
        """Refuse a token that was revoked, until the store could remove it.

        Raises
        ------
        Unavailable
            Only this endpoint refuses it, or all do, but not after a restart of the cloud.
        """
        if (user_id, token_hash) not in self._refused:
            later = asyncio.create_task(self._remove_later(user_id, token_hash))
            self._refused[user_id, token_hash] = later
        await self._logins.refuse_token(user_id, token_hash)

    async def is_refused(self, user_id: str, token_hash: str) -> bool:
        """Return whether a token was revoked; without the other endpoints, as far as this one knows."""
        if (user_id, token_hash) in self._refused:
            return True
        try:
            return await self._logins.is_refused(user_id, token_hash)
        except Unavailable as error:
            logger.debug("the other endpoints cannot be asked for revoked tokens: %s", error)
            return False

    def close(self) -> None:
        """Stop to remove tokens."""
        for later in self._refused.values():
            later.cancel()

    def _remove(self, user_id: str, token_hash: str) -> None:
        if self._store.token(token_hash).user != user_id:
            raise NotFound("token", token_hash)
        self._store.remove_token(token_hash)

    async def _remove_later(self, user_id: str, token_hash: str) -> None:
        while (user_id, token_hash) in self._refused:
            await asyncio.sleep(self._retry)
            try:
                await run_in_threadpool(self._remove, user_id, token_hash)
            except Unavailable:
                with contextlib.suppress(Unavailable):  # another master may lead now, which does not know it
                    await self._logins.refuse_token(user_id, token_hash)
                continue
            except NotFound:
                logger.debug("a revoked token was removed meanwhile")
            except Exception:
                logger.exception("a revoked token cannot be removed from the store")
                continue
            await self._forget(user_id, token_hash)

    async def _forget(self, user_id: str, token_hash: str) -> None:
        self._refused.pop((user_id, token_hash), None)
        try:
            await self._logins.removed_token(user_id, token_hash)
        except Unavailable as error:  # it is refused for longer, although it is gone
            logger.debug("the other endpoints cannot be told: %s", error)


class TokenCache(StoreCache[User]):
    """Users of recently verified tokens, by the hashes of the tokens; of one endpoint.

    Each endpoint is notified when another one changes a user (``SharedLogins.forget``). One that cannot be notified
    accepts a revoked token for the lifetime of an entry.
    """

    def forget_user(self, user_id: str) -> None:
        """Drop all tokens of a user from the cache."""
        self.forget_where(lambda user: user.id == user_id)


class ScopedUser(User, frozen=True, kw_only=True):
    """User whose request was authenticated by a scoped token: an ordinary user, also if the user is an administrator.

    ``scope`` is the token's scope. The password hash is empty.
    """

    scope: TokenScope


def user_of_token(user: User, token: Token) -> User:
    """Return the caller who sent a token: a `ScopedUser` if the token has a scope."""
    if token.scope is None:
        return user
    fields = msgspec.structs.asdict(user) | {"role": "user", "password_hash": ""}
    return ScopedUser(**fields, scope=token.scope)


TOKEN_LIFETIME = 30 * 24 * 3600.0
"""Lifetime of a token [s]."""

MAX_TOKEN = 256
TOKEN_PREFIX = "ppaas_"
"""Prefix of tokens: none starts with a dash like an option of a command, and leaked tokens can be found."""


@dataclass(frozen=True, slots=True)
class IssuedToken:
    """New token and its expiry [s since the epoch]."""

    token: str
    expires: float

    @property
    def id(self) -> str:
        """Hash of the token, under which it is stored and revoked."""
        return token_id(self.token)


class Tokens:
    """Tokens of users, of which only the hashes are stored, so that a reader of the store cannot impersonate a user.

    Parameters
    ----------
    store : UserStore
        Store of users and tokens.
    clock : callable
        Returns the time [s since the epoch].
    lifetime : float
        Lifetime of a token [s].
    cache : TokenCache
        Cache of verified tokens, of this process.
    logins : SharedLogins
        Where tokens are kept that cannot be stored.
    """

    def __init__(
        self, store: UserStore, clock: Clock, *, lifetime: float, cache: TokenCache, logins: SharedLogins
    ) -> None:
        self._store = store
        self._clock = clock
        self._lifetime = lifetime
        self._cache = cache
        self._logins = logins
        self._revocations = Revocations(store, logins)

    async def refuse(self, tokens: Iterable[RefusedToken]) -> None:
        """Refuse tokens that were revoked before a restart of the cloud, and remove them from the store."""
        for user_id, token_hash in tokens:
            await self._revocations.refuse(user_id, token_hash)

    def close(self) -> None:
        """Stop to remove revoked tokens from the store."""
        self._revocations.close()

    async def issue(
        self, user_id: str, lifetime: float | None = None, provider_session: str | None = None
    ) -> IssuedToken:
        """Return a new token, stored, or kept in memory for a while if the store takes nothing, as on a full disk.

        ``lifetime`` is its own, if it has one [s]; ``provider_session`` is as of ``Token``.
        """
        now, text = self._clock(), _new_text()
        lifetime = self._lifetime if lifetime is None else lifetime
        try:
            issued = IssuedToken(text, now + lifetime)
            return await run_in_threadpool(self._store_new, issued, user_id, now, provider_session)
        except Unavailable as error:
            login = IssuedToken(text, now + min(lifetime, UNSAVED_LIFETIME))
            kept = Token(login.id, user_id, login.expires, now, provider_session=provider_session)
            await self._logins.keep_token(kept)
            logger.warning("the token of user %r is kept in memory for %g s: %s", user_id, login.expires - now, error)
            return login

    async def issue_scoped(self, user_id: str, scope: TokenScope, lifetime: float, name: str) -> IssuedToken:
        """Return a new token for some robots only; ``NotFound`` if the user does not exist."""
        now = self._clock()
        issued = IssuedToken(_new_text(), now + lifetime)
        await run_in_threadpool(self._store.add_token, Token(issued.id, user_id, issued.expires, now, scope, name))
        return issued

    async def user_of(self, token_hash: str) -> User:
        """Return the user of a token, given by its id; ``NotAuthenticated`` if the token is unknown or expired."""
        now = self._clock()
        return await self._cache.read(token_hash, now, lambda: self._user_and_expiry(token_hash, now))

    async def revoke(self, user_id: str, token_hash: str) -> None:
        """Revoke a token of a user; ``NotFound`` if the user has no such token.

        All endpoints refuse it from now on, also if it cannot be removed from the store yet, as on a full disk.
        """
        try:
            await self._revocations.remove(user_id, token_hash)
        except NotFound:
            if (await self._kept(token_hash)).user != user_id or not await self._logins.drop_token(token_hash):
                raise
        finally:
            await self.forget(user_id)

    async def revoke_all(self, user_id: str, which: Callable[[Token], bool] = lambda _: True) -> int:
        """Revoke the tokens of a user that ``which`` selects, and those that could not be stored; return their number.

        The number is without those that could not be stored.
        """
        try:
            await self._logins.drop_tokens(user_id, None)
            revoked = [token for token in await run_in_threadpool(self._store.tokens, user_id) if which(token)]
            for token in revoked:
                with contextlib.suppress(NotFound):  # revoked or expired meanwhile
                    await self._revocations.remove(user_id, token.hash)
            return len(revoked)
        finally:
            await self.forget(user_id)

    async def drop_kept(self, user_id: str, *, keep: str | None = None) -> None:
        """Drop the tokens of a user that could not be stored, except one.

        It is done before the user is changed: if it fails, nothing is changed, and the caller can try again.
        """
        await self._logins.drop_tokens(user_id, keep)

    async def forget(self, user_id: str) -> None:
        """Make all endpoints read a user and the user's tokens again.

        If the others cannot be notified now, they accept the tokens for the lifetime of an entry of their cache.
        """
        self.forget_user(user_id)
        try:
            await self._logins.forget(user_id)
        except Unavailable as error:
            logger.warning("other endpoints follow the changes of user %r later: %s", user_id, error)

    def forget_user(self, user_id: str) -> None:
        """Drop a user from the cache of this process."""
        self._cache.forget_user(user_id)

    def forget_all(self) -> None:
        """Drop all users from the cache of this process."""
        self._cache.drop_all()

    def _store_new(self, login: IssuedToken, user_id: str, now: float, provider_session: str | None) -> IssuedToken:
        self._store.add_token(Token(login.id, user_id, login.expires, now, provider_session=provider_session))
        with contextlib.suppress(Unavailable):  # a later login removes them
            self._store.remove_tokens(expired_before=now)
        return login

    async def _user_and_expiry(self, token_hash: str, now: float) -> tuple[User, float]:
        try:
            try:
                user, token = await run_in_threadpool(self._stored, token_hash)
            except NotFound:
                self._cache.drop(token_hash)
                token = await self._kept(token_hash)
                user = await run_in_threadpool(self._store.user, token.user)
        except NotFound as error:
            raise _unknown_token() from error
        if token.expires <= now or user.leaving or await self._revocations.is_refused(token.user, token_hash):
            raise _unknown_token()
        return user_of_token(user, token), token.expires

    def _stored(self, token_hash: str) -> tuple[User, Token]:
        token = self._store.token(token_hash)
        return self._store.user(token.user), token

    async def _kept(self, token_hash: str) -> Token:
        token = await self._logins.kept_token(token_hash)
        if token is None:
            raise NotFound("token", token_hash)
        return token


def token_id(token: str) -> str:
    """Return the SHA-256 hash of a token, under which it is stored."""
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()


def received_token_id(token: str) -> str:
    """Return the id of a token that a client sent; ``NotAuthenticated`` if no token is this short or long."""
    if not 0 < len(token) <= MAX_TOKEN:
        raise _unknown_token()
    return token_id(token)


def _new_text() -> str:
    return f"{TOKEN_PREFIX}{secrets.token_urlsafe(32)}"


def _unknown_token() -> NotAuthenticated:
    return NotAuthenticated("the token is unknown or expired: log in again ('ppaas login', or POST /v1/tokens)")
