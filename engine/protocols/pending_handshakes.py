"""Who may dial: each by name, with a secret, once."""

import hmac
from typing import Generic, TypeVar

from ppaas.errors import NotPermitted

T = TypeVar("T")


def is_same(secret: str, given: str) -> bool:
    """Compare secrets in a time that tells nothing of them; what is given may be any text."""
    return hmac.compare_digest(secret.encode(), given.encode())


class PendingHandshakes(Generic[T]):
    """Those who have not dialled yet, and what is known of each."""

    def __init__(self) -> None:
        self._awaited: dict[str, tuple[str, T]] = {}

    def __len__(self) -> int:
        """Return how many are still to come."""
        return len(self._awaited)

    def expect(self, name: str, secret: str, known: T) -> None:
        """Await somebody, once."""
        self._awaited[name] = (secret, known)

    def forget(self, name: str) -> None:
        """Await somebody no more."""
        self._awaited.pop(name, None)

    def admit(self, name: str, given: str) -> T:
        """Return what is known of whoever dials now.

        A wrong secret changes nothing: a stranger cannot take the place of the one who is awaited.

        Raises
        ------
        NotPermitted
            Nobody of that name is awaited, or the secret is wrong.
        """
        if name not in self._awaited or not is_same(self._awaited[name][0], given):
            raise NotPermitted(f"{name[:64]!r} is not awaited, or has the wrong secret")
        return self._awaited.pop(name)[1]
