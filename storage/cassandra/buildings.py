"""Buildings in Cassandra: those of a user are a partition."""

from storage.buildings.records import BuildingRecord, no_building
from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.sorted_rows import SortedRows, generation_of, remove_marked
from storage.encoding import decode, decode_readable, encode
from storage.names import check_building_key, check_name

_OF_USER = "user = ? AND generation = ?"
_ROWS = SortedRows("buildings", _OF_USER, "id", "generation DESC, id DESC", "record")
_PUT = f"UPDATE buildings SET record = ? WHERE {_OF_USER} AND id = ? IF record = ?"

_OfUser = tuple[str, int]
"""User, and the user's generation (``storage.cassandra.connection.cluster``)."""


class CassandraBuildings:
    """A ``BuildingStore`` in Cassandra.

    A removal first empties the record, and then deletes the row (``storage.cassandra.sorted_rows``).
    """

    _session: CassandraSession

    def put_building(self, record: BuildingRecord, *, instead_of: BuildingRecord | None = None) -> None:
        """Store a building; ``Conflict`` if the stored one is not ``instead_of``."""
        user, building = check_building_key(*record.key)
        group, data = self._building_group(user), encode(record)
        while True:
            before = self._building_record(group, building)
            if _read(before, group, building) != instead_of:
                raise record.changed_meanwhile()
            if self._session.write_if(_PUT, data, *group, building, before):
                return

    def building(self, user: str, building: str) -> BuildingRecord:
        """Return a building; ``NotFound`` if it does not exist."""
        check_building_key(user, building)
        group = self._building_group(user)
        found = _read(self._building_record(group, building), group, building)
        if found is None:
            raise no_building(building)
        return found

    def buildings(self, user: str, *, after: str = "", limit: int | None = None) -> list[BuildingRecord]:
        """Return the buildings of a user, sorted by id."""
        query, group = f"SELECT id, record FROM buildings WHERE {_OF_USER} AND id > ?", self._building_group(user)
        rows = (row for row in self._session.rows(query, *group, after) if row.record)
        return decode_readable(((row.record, _place(group, row.id)) for row in rows), BuildingRecord, limit)

    def building_users(self) -> list[str]:
        """Return the users who have buildings, sorted."""
        return [user for user in self._session.partitions("buildings", "user") if self.buildings(user, limit=1)]

    def remove_building(self, user: str, building: str, *, instead_of: BuildingRecord | None = None) -> None:
        """Remove a building; ``Conflict`` if ``instead_of`` is given and differs from the stored one."""
        check_building_key(user, building)
        group = self._building_group(user)
        while before := self._building_record(group, building):
            if instead_of is not None and _read(before, group, building) != instead_of:
                raise instead_of.changed_meanwhile()
            if self._session.write_if(_PUT, b"", *group, building, before):
                remove_marked(self._session, _ROWS, group, building)
                return
        raise no_building(building)

    # -- internals -----------------------------------------------------------------------------------------------------

    def _sweep_buildings(self, user: str, generation: int) -> None:
        """Delete the buildings of a former user of an id."""
        if self._session.row(f"SELECT id FROM buildings WHERE {_OF_USER} LIMIT 1", user, generation) is not None:
            self._session.write(f"DELETE FROM buildings WHERE {_OF_USER}", user, generation)

    def _building_group(self, user: str) -> _OfUser:
        return check_name("user", user), generation_of(self._session, user)

    def _building_record(self, group: _OfUser, building: str) -> bytes | None:
        row = self._session.row(f"SELECT record FROM buildings WHERE {_OF_USER} AND id = ?", *group, building)
        return None if row is None else row.record


def _read(data: bytes | None, group: _OfUser, building: str) -> BuildingRecord | None:
    return decode(data, BuildingRecord, _place(group, building)) if data else None


def _place(group: _OfUser, building: str) -> str:
    return f"buildings/{group[0]}/{building}"
