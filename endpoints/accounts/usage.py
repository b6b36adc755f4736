"""What a user keeps in the stores, and whether one more may come to it."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from weakref import WeakValueDictionary

from engine.master.quotas import Quotas, check_quota
from ppaas.errors import NotFound
from storage.ports import MapStore, Store


class Usage:
    """Lets each user keep one new thing at a time, so that two who come together do not both take the last place.

    Several processes that serve one store do not wait for each other: there may be one too many for each.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._adding: WeakValueDictionary[str, threading.Lock] = WeakValueDictionary()

    @contextmanager
    def new_robot(self, store: Store, quotas: Quotas, user: str, robot: str) -> Iterator[None]:
        """Keep a robot in the block, which may be there already; blocks.

        Raises
        ------
        QuotaExceeded
            It would be one too many.
        """
        with self._of(user):
            try:
                store.robot(user, robot)
            except NotFound:
                check_quota(user, "robots", quotas.of(user).robots, robot_count(store, user))
            yield

    @contextmanager
    def new_map(self, map_store: MapStore, quotas: Quotas, user: str, map_id: str) -> Iterator[None]:
        """Publish a map in the block, which may be there already; blocks.

        Raises
        ------
        QuotaExceeded
            It would be one too many.
        """
        with self._of(user):
            try:
                map_store.map_head(map_id)
            except NotFound:
                check_quota(user, "maps", quotas.of(user).maps, len(owned_maps(map_store, user)))
            yield

    def _of(self, user: str) -> threading.Lock:
        with self._lock:
            return self._adding.setdefault(user, threading.Lock())


def robot_count(store: Store, user: str) -> int:
    """Return how many robots a user has."""
    return len(store.robots(user))


def owned_maps(map_store: MapStore, user: str) -> list[str]:
    """Return the maps that a user owns."""
    return [head.id for head in map_store.maps(user) if head.owner == user]
