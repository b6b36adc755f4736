"""Pending handshakes: connections that are expected, each by name, with a secret, once."""

import hmac
from typing import Generic, TypeVar

from ppaas.errors import NotPermitted

T = TypeVar("T")


def is_same(secret: str, given: str) -> bool:
    """Compare secrets in constant time."""
    return hmac.compare_digest(secret.encode(), given.encode())


class PendingHandshakes(Generic[T]):
    """The expected connections, each with data for its handler."""

    def __init__(self) -> None:
        self._pending: dict[str, tuple[str, T]] = {}

    def __len__(self) -> int:
        """Return the number of expected connections."""
        return len(self._pending)

    def expect(self, name: str, secret: str, known: T) -> None:
        """Expect one connection with this name and secret."""
        self._pending[name] = (secret, known)

    def forget(self, name: str) -> None:
        """Stop expecting a connection."""
        self._pending.pop(name, None)

    def check(self, name: str, given: str) -> T:
        """Return the data of an expected connection, which is still expected; raises as ``admit`` does."""
        if name not in self._pending or not is_same(self._pending[name][0], given):
            raise NotPermitted(f"{name[:64]!r} is not expected here, or has the wrong secret")
        return self._pending[name][1]

    def admit(self, name: str, given: str) -> T:
        """Accept a connection; return the data that was passed to ``expect``.

        After a wrong secret the connection is still expected, so a stranger cannot take its place.

        Raises
        ------
        NotPermitted
            The name is not expected, or the secret is wrong.
        """
        known = self.check(name, given)
        self.forget(name)
        return known
