"""Stores on a local disk that store nothing new while the disk is full.

Calls that free space or withdraw a right still work: tokens, passwords, roles and limits of users, the readers of maps,
and all removals. They need little space, which the reserve provides (``storage.disk_space.reserve``).
"""

from collections.abc import Callable
from typing import Any

from ppaas.errors import Unavailable
from storage.disk_space.reserve import DiskReserve
from storage.ports import MapStore, Store

REFUSED = frozenset(
    {
        "add_user",
        "put_robot",
        "put_urdf",
        "add_plan",
        "add_plans",
        "replace_plan",
        "save_clone",
        "add_history",
        "put_link",
        "add_people_counts",
        "stage",
        "publish",
        "propose",
        "approve",
        "roll_back",
    }
)
"""Methods of both ports that a full disk refuses."""

FULL = (
    "the disk of the cloud is full: an administrator must free space, for example by removing maps or plans; robots "
    "drive on, and rights can be withdrawn"
)


class GuardedStore:
    """A ``Store`` or a ``MapStore`` on a local disk. Calls that a full disk refuses raise ``Unavailable``.

    Parameters
    ----------
    store : Store or MapStore
    reserve : DiskReserve
        Reserve on the same disk.
    """

    def __init__(self, store: Store | MapStore, reserve: DiskReserve) -> None:
        self._store = store
        self._reserve = reserve

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the store; a method that a full disk refuses checks the disk first."""
        found = getattr(self._store, name)
        if name not in REFUSED:
            return found
        guarded = self._checked(found)
        setattr(self, name, guarded)
        return guarded

    def _checked(self, method: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            if self._reserve.is_full():
                raise Unavailable(FULL)
            return method(*arguments, **options)

        return call
