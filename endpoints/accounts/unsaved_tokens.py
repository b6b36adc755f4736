"""Tokens that could not be stored: kept in memory for a while, so that an administrator can log in and make room."""

import threading

from ppaas.bounded import BoundedDict
from storage.records import Token

UNSAVED_LIFETIME = 900.0
"""Lifetime of a token that is not stored [s]."""

MAX_UNSAVED = 256
"""Largest number of such tokens; of more, the oldest are forgotten."""


class UnsavedTokens:
    """Tokens that are in the memory of one process alone. Thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._tokens: BoundedDict[str, Token] = BoundedDict(MAX_UNSAVED)

    def add(self, token: Token) -> None:
        """Keep a token until it expires, is removed, or many newer ones were added."""
        with self._lock:
            self._tokens[token.hash] = token

    def find(self, token_hash: str) -> Token | None:
        """Return a token, expired or not; None if it is not one of these."""
        return self._tokens.get(token_hash)

    def remove(self, token_hash: str) -> bool:
        """Remove a token; return whether it was one of these."""
        with self._lock:
            return self._tokens.pop(token_hash, None) is not None

    def remove_all(self, user: str, *, keep: str | None = None) -> None:
        """Remove the tokens of a user, except one."""
        with self._lock:
            for token in list(self._tokens.values()):
                if token.user == user and token.hash != keep:
                    del self._tokens[token.hash]
