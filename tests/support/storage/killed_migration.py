"""A migration that is killed after n writes: ``python -m tests.support.storage.killed_migration FROM TO N``."""

import os
import signal
import sys
from typing import Any

from storage.migration.copying import StoredKind, copy
from storage.migration.map_records import MAP_KINDS
from storage.migration.store_records import KINDS
from storage.urls.opening import open_map_store, open_store
from storage.urls.registry import MAP_STORES

WRITES = (
    "add_user", "add_token", "put_robot", "put_urdf", "save_clone", "add_plans", "add_history", "put_link", "publish",
    "roll_back", "put_people_settings", "add_people_counts", "put_task", "put_building",
    "put_webhook", "put_delivery",
)  # fmt: skip


class Fatal:
    """A store that kills the process at the write after a given number."""

    def __init__(self, store: Any, left: int) -> None:
        self._store = store
        self._left = left

    def __getattr__(self, name: str) -> Any:
        method = getattr(self._store, name)
        if name not in WRITES:
            return method

        def write(*arguments: Any, **options: Any) -> Any:
            if self._left == 0:
                os.kill(os.getpid(), signal.SIGKILL)
            self._left -= 1
            return method(*arguments, **options)

        return write


def main() -> None:
    source, target, left = sys.argv[1], sys.argv[2], int(sys.argv[3])
    is_map_store = target.partition(":")[0] in MAP_STORES
    opened: Any = open_map_store if is_map_store else open_store
    kinds: tuple[StoredKind[Any], ...] = MAP_KINDS if is_map_store else KINDS
    stores = opened(source), Fatal(opened(target), left)
    for kind in kinds:
        for _ in copy(kind, *stores):
            pass


if __name__ == "__main__":
    main()
