"""Reference of all map stores: the history of maps in plain lists. Every store must give the same answers."""

from typing import Any

from ppaas.errors import Conflict, NotFound
from storage.names import check_name
from tests.support.storage.records import GivenMap


class PlainMaps:
    """Maps by id, each with the list of its publications."""

    def __init__(self) -> None:
        self.maps: dict[str, dict[str, Any]] = {}

    def put(self, given: GivenMap, if_match: str | None) -> dict[str, Any]:
        check_name("map", given.id)
        check_name("user", given.owner)
        before = self.maps.get(given.id)
        self._check(before, given.id, given.owner, if_match)
        history = list(before["history"]) if before else []
        if not history or history[-1][0] != given.version:
            history.append((given.version, given.created, given.owner, False))
        metadata = {"owner": given.owner, "readers": tuple(given.readers), "description": given.description}
        files = (before["files"] if before else {}) | {given.version: given.files}
        self.maps[given.id] = metadata | {"history": history, "files": files}
        return self.head(given.id)

    def roll_back(self, map_id: str, version: str, owner: str, created: float) -> dict[str, Any]:
        check_name("map", map_id)
        check_name("user", owner)
        found = self._known(map_id)
        self._check(found, map_id, owner, None)
        if version not in found["files"]:
            raise NotFound(f"version of map {map_id!r}:", version)
        if found["history"][-1][0] != version:
            found["history"].append((version, created, owner, True))
        return self.head(map_id)

    def change(self, map_id: str, readers: tuple[str, ...] | None, description: str | None) -> dict[str, Any]:
        check_name("map", map_id)
        found = self._known(map_id)
        found["readers"] = found["readers"] if readers is None else readers
        found["description"] = found["description"] if description is None else description
        return self.head(map_id)

    def remove(self, map_id: str) -> None:
        check_name("map", map_id)
        self._known(map_id)
        del self.maps[map_id]

    def head(self, map_id: str) -> dict[str, Any]:
        check_name("map", map_id)
        found = self._known(map_id)
        return {key: found[key] for key in ("owner", "readers", "description")} | {"present": found["history"][-1]}

    def versions(self, map_id: str, limit: int | None) -> list[tuple[Any, ...]]:
        check_name("map", map_id)
        return self._known(map_id)["history"][::-1][:limit]

    def ids(self, reader: str | None, after: str, limit: int | None) -> list[str]:
        found = [
            map_id
            for map_id in sorted(self.maps)
            if map_id > after
            and (reader is None or reader in (self.maps[map_id]["owner"], *self.maps[map_id]["readers"]))
        ]
        return found[:limit]

    def files(self, map_id: str) -> dict[str, bytes]:
        check_name("map", map_id)
        found = self._known(map_id)
        return found["files"][found["history"][-1][0]]

    def _known(self, map_id: str) -> dict[str, Any]:
        if map_id not in self.maps:
            raise NotFound("map", map_id)
        return self.maps[map_id]

    def _check(self, before: dict[str, Any] | None, map_id: str, owner: str, if_match: str | None) -> None:
        if before is not None and before["owner"] != owner:
            raise Conflict(f"map {map_id!r} belongs to another user: choose another id")
        present = None if before is None else before["history"][-1][0]
        if if_match not in (None, present):
            current = "does not exist" if present is None else f"is at version {present}"
            raise Conflict(f"map {map_id!r} {current}, not at version {if_match}: read it again and retry")
