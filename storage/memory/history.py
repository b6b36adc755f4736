"""Planning history in memory."""

import threading
from collections.abc import Iterable

from ppaas.plans.history import LinkHistory, PlannerHistory
from storage.history_checks import check_history, check_link
from storage.names import check_name


class MemoryHistory:
    """A ``HistoryStore`` of dictionaries."""

    def __init__(self) -> None:
        self._history_lock = threading.Lock()
        self._history: dict[tuple[str, str, str, int], PlannerHistory] = {}
        self._links: dict[str, LinkHistory] = {}

    def add_history(self, rows: Iterable[PlannerHistory]) -> None:
        """Add each row to the sums of its key, all or none."""
        checked = [check_history(row) for row in rows]
        with self._history_lock:
            for row in checked:
                kept = self._history.get(row.key)
                self._history[row.key] = row if kept is None else kept.plus(row)

    def history(self, map_id: str, version: str | None = None) -> list[PlannerHistory]:
        """Return the rows of a map, or of one of its versions, sorted by key."""
        check_name("map", map_id)
        with self._history_lock:
            rows = sorted(self._history.items())
        return [row for _, row in rows if row.map == map_id and version in (None, row.version)]

    def history_maps(self) -> list[str]:
        """Return the ids of the maps that have rows, sorted."""
        with self._history_lock:
            return sorted({row.map for row in self._history.values()})

    def remove_history(self, map_id: str) -> None:
        """Remove the rows of a map, if it has any."""
        check_name("map", map_id)
        with self._history_lock:
            self._history = {key: row for key, row in self._history.items() if row.map != map_id}

    def put_link(self, row: LinkHistory) -> None:
        """Store the measurements of a link in place of the previous ones."""
        checked = check_link(row)
        with self._history_lock:
            self._links[checked.link] = checked

    def links(self) -> list[LinkHistory]:
        """Return the measurements of all links, sorted by name."""
        with self._history_lock:
            return [self._links[name] for name in sorted(self._links)]
