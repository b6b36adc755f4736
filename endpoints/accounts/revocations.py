"""Revocations of tokens, which hold in the whole cloud at once, also where the store cannot be written yet."""

import asyncio
import contextlib
import logging

from starlette.concurrency import run_in_threadpool

from endpoints.accounts.shared_logins import SharedLogins
from ppaas.errors import NotFound, Unavailable
from storage.ports import UserStore

logger = logging.getLogger(__name__)

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
