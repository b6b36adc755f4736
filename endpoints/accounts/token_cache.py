"""Tokens that were verified a moment ago, so that a request does not wait for the store each time."""

from collections import OrderedDict
from dataclasses import dataclass, replace

from storage.records import User

AWAY = 5.0
"""Seconds for which a store that is away is not asked for the same again: it may take as long to say that it is."""


@dataclass(frozen=True, slots=True)
class _Entry:
    user: User
    until: float
    last: float


class TokenCache:
    """The last verified tokens, by their hashes. For one event loop.

    Parameters
    ----------
    size : int
        Most entries; the one unused for longest goes first.
    lifetime : float
        How long one is believed [s]: so long may a user who was removed elsewhere go on.
    patience : float
        How long one is believed while the store cannot be asked [s].
    """

    def __init__(self, size: int = 4096, lifetime: float = 30.0, patience: float = 24 * 3600.0) -> None:
        self._size = size
        self._lifetime = lifetime
        self._patience = patience
        self._entries: OrderedDict[str, _Entry] = OrderedDict()
        self.forgotten = 0
        """How often users were forgotten: what was read from the store before may be no more."""

    def get(self, token_hash: str, now: float) -> User | None:
        """Return the user of a token, or None if the store must be asked."""
        entry = self._entries.get(token_hash)
        if entry is None:
            return None
        if now >= entry.until:
            return None
        self._entries.move_to_end(token_hash)
        return entry.user

    def put(self, token_hash: str, user: User, now: float, expires: float) -> None:
        """Believe a token for a while, and not beyond its expiry."""
        self._entries[token_hash] = _Entry(user, min(now + self._lifetime, expires), min(now + self._patience, expires))
        self._entries.move_to_end(token_hash)
        while len(self._entries) > self._size:
            self._entries.popitem(last=False)

    def last_known(self, token_hash: str, now: float) -> User | None:
        """Return whose token it was when the store could be asked; it is believed for a moment more."""
        entry = self._entries.get(token_hash)
        if entry is None or now >= entry.last:
            return None
        self._entries[token_hash] = replace(entry, until=min(now + AWAY, entry.last))
        return entry.user

    def forget(self, user_id: str) -> None:
        """Believe no token of a user any more."""
        self.forgotten += 1
        self._entries = OrderedDict((key, entry) for key, entry in self._entries.items() if entry.user.id != user_id)
