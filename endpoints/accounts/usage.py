"""Usage of stored resources per user, checked against the quota before one is added."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from weakref import WeakValueDictionary

from engine.master.quotas import Quotas, check_quota
from ppaas.errors import NotFound
from storage.ports import MapStore, Store


class Usage:
    """Quota checks of new robots and maps, serialised per user so that two requests cannot both use the last place.

    Processes that share a store do not wait for each other: each of them may exceed the quota by one.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._adding: WeakValueDictionary[str, threading.Lock] = WeakValueDictionary()

    @contextmanager
    def new_robot(self, store: Store, quotas: Quotas, user: str, robot: str) -> Iterator[None]:
        """Check the quota, then store a robot, new or existing, in the ``with`` block; blocks the thread.

        Raises
        ------
        QuotaExceeded
            The robot is new and the user already has the maximum.
        """
        with self._of(user):
            try:
                store.robot(user, robot)
            except NotFound:
                check_quota(user, "robots", quotas.of(user).robots, robot_count(store, user))
            yield

    @contextmanager
    def new_map(self, map_store: MapStore, quotas: Quotas, user: str, map_id: str) -> Iterator[None]:
        """Check the quota, then publish a map, new or existing, in the ``with`` block; blocks the thread.

        Raises
        ------
        QuotaExceeded
            The map is new and the user already has the maximum.
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
    """Return the number of robots of a user."""
    return len(store.robots(user))


def owned_maps(map_store: MapStore, user: str) -> list[str]:
    """Return the ids of the maps that a user owns."""
    return [head.id for head in map_store.maps(user) if head.owner == user]
