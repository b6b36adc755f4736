"""Queue that is fair to addresses, and to the users of one address.

A flood of requests waits behind itself: each address has its turn, and at an address each user. A full queue drops the
newest request of the address that has most of them.
"""

from collections import OrderedDict, deque
from typing import Generic, Literal, NamedTuple, TypeVar

T = TypeVar("T")

LoginKind = Literal["password", "rapyuta"]
"""Kind of a login: with the password of a user, or with that for the robots of a user, by the protocol of Rapyuta."""


class RequestOrigin(NamedTuple):
    """Origin of a request.

    Parameters
    ----------
    user : str
        Name of the user, whether or not the user exists.
    address : str
        Address of the client; empty for requests of this process.
    known : bool
        Whether the user has logged in from this address before; such requests are served first.
    kind : {"password", "rapyuta"}
        Kind of the login.
    """

    user: str = ""
    address: str = ""
    known: bool = False
    kind: LoginKind = "password"


class FairQueue(Generic[T]):
    """Items by origin.

    Parameters
    ----------
    size : int
        Largest number of items.
    """

    def __init__(self, size: int) -> None:
        self._size = size
        self._lanes = {known: _Lane[T]() for known in (True, False)}

    def __len__(self) -> int:
        """Return the number of items."""
        return sum(lane.length for lane in self._lanes.values())

    def push(self, origin: RequestOrigin, item: T) -> T | None:
        """Add an item; return the one that is dropped for it, perhaps the item itself, or None if there was space."""
        self._lanes[origin.known].push(origin, item)
        if len(self) <= self._size:
            return None
        return self._lanes[not self._lanes[False].length].drop()

    def discard(self, origin: RequestOrigin, item: T) -> None:
        """Remove an item, if it is in the queue."""
        self._lanes[origin.known].discard(origin, item)

    def pop(self) -> T | None:
        """Remove and return the next item, or None if the queue is empty."""
        lane = self._lanes[self._lanes[True].length > 0]
        return lane.pop() if lane.length else None


class _Lane(Generic[T]):
    """Items of one priority, by address and user."""

    def __init__(self) -> None:
        self._by_address: OrderedDict[str, OrderedDict[str, deque[T]]] = OrderedDict()
        self._counts: dict[str, int] = {}
        self.length = 0

    def push(self, origin: RequestOrigin, item: T) -> None:
        of_user = self._by_address.setdefault(origin.address, OrderedDict())
        of_user.setdefault(origin.user, deque()).append(item)
        self._count(origin.address, 1)

    def discard(self, origin: RequestOrigin, item: T) -> None:
        users = self._by_address.get(origin.address)
        if users is not None and item in users.get(origin.user, ()):
            users[origin.user].remove(item)
            self._removed(origin.address, origin.user)

    def pop(self) -> T:
        address = next(iter(self._by_address))
        users = self._by_address[address]
        user = next(iter(users))
        item = users[user].popleft()
        self._by_address.move_to_end(address)
        users.move_to_end(user)
        self._removed(address, user)
        return item

    def drop(self) -> T:
        address = max(self._counts, key=lambda address: self._counts[address])
        users = self._by_address[address]
        user = max(reversed(users), key=lambda user: len(users[user]))  # the newest of equals
        item = users[user].pop()
        self._removed(address, user)
        return item

    def _removed(self, address: str, user: str) -> None:
        self._count(address, -1)
        if not self._by_address[address][user]:
            del self._by_address[address][user]
        if not self._counts[address]:
            del self._counts[address], self._by_address[address]

    def _count(self, address: str, change: int) -> None:
        self._counts[address] = self._counts.get(address, 0) + change
        self.length += change
