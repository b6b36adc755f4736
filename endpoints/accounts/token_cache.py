"""Cache of verified tokens, so that not every request waits for the store."""

from collections import OrderedDict
from dataclasses import dataclass, replace

from storage.records import User

RETRY = 5.0
"""Time after which an unreachable store is queried again for the same token [s]; a query may take as long to fail."""


@dataclass(frozen=True, slots=True)
class _CachedToken:
    user: User
    until: float
    last: float


class TokenCache:
    """Recently verified tokens by their hashes; for use on one event loop.

    Parameters
    ----------
    size : int
        Largest number of entries; the least recently used is evicted first.
    lifetime : float
        Time for which an entry is valid [s]; a user removed by another process stays authenticated for so long.
    patience : float
        Time for which an entry is used while the store is unreachable [s].
    """

    def __init__(self, size: int = 4096, lifetime: float = 30.0, patience: float = 24 * 3600.0) -> None:
        self._size = size
        self._lifetime = lifetime
        self._patience = patience
        self._entries: OrderedDict[str, _CachedToken] = OrderedDict()
        self.forgotten = 0
        """Number of calls of `forget`: a result read from the store before the last one may be outdated."""

    def get(self, token_hash: str, now: float) -> User | None:
        """Return the user of a token, or None if the store must be queried."""
        entry = self._entries.get(token_hash)
        if entry is None:
            return None
        if now >= entry.until:
            return None
        self._entries.move_to_end(token_hash)
        return entry.user

    def put(self, token_hash: str, user: User, now: float, expires: float) -> None:
        """Cache a token, at most until it expires."""
        self._entries[token_hash] = _CachedToken(
            user, min(now + self._lifetime, expires), min(now + self._patience, expires)
        )
        self._entries.move_to_end(token_hash)
        while len(self._entries) > self._size:
            self._entries.popitem(last=False)

    def last_known(self, token_hash: str, now: float) -> User | None:
        """Return the user of a cached token while the store is unreachable, and extend it by `RETRY` seconds."""
        entry = self._entries.get(token_hash)
        if entry is None or now >= entry.last:
            return None
        self._entries[token_hash] = replace(entry, until=min(now + RETRY, entry.last))
        return entry.user

    def forget(self, user_id: str) -> None:
        """Drop all tokens of a user from the cache."""
        self.forgotten += 1
        self._entries = OrderedDict((key, entry) for key, entry in self._entries.items() if entry.user.id != user_id)
