"""Shared segments of plans with their checksum: a damaged one spoils its plans alone, until it is stored again."""

import sqlite3
import zlib
from collections.abc import Iterable, Iterator

from ppaas.errors import PPaaSError
from ppaas.plans.encoding.codes import entry_id, pack, poses_of, unpack, waypoints_in
from ppaas.plans.encoding.end_buckets import cell_number
from ppaas.plans.encoding.index_cells import cells_touched, scope_of
from storage.sqlite.plan_counts import rows_of


def is_intact(data: bytes, crc: int | None) -> bool:
    """Return whether a packed segment has its checksum; segments of earlier releases have none."""
    return crc is None or crc == zlib.crc32(data)


def intact_segments(connection: sqlite3.Connection, numbers: Iterable[int]) -> dict[int, bytes]:
    """Return the packed segments with these numbers, without those that are missing or damaged."""
    query = "SELECT sought.id, data, crc FROM {given} AS sought JOIN chunks ON chunks.id = sought.id"
    return {number: data for number, data, crc in rows_of(connection, query, list(numbers)) if is_intact(data, crc)}


def find_or_add(connection: sqlite3.Connection, key: bytes, scope: int) -> int:
    """Return the number of a segment; a damaged one is written again, a missing one is added.

    Parameters
    ----------
    connection : Connection
        In a transaction.
    key : bytes
        The 16 bytes of its map version, then its code.
    scope : int
        Number of its map version.
    """
    version, code = key[:16], key[16:]
    entry = entry_id(version, code)
    query = "SELECT chunk, data, crc FROM chunk_ids JOIN chunks ON chunks.id = chunk WHERE entry = ?"
    row = connection.execute(query, (entry,)).fetchone()
    if row is None:
        return _add(connection, entry, version, code, scope)
    number, data, crc = row
    if not is_intact(data, crc):
        packed = pack(code)
        connection.execute("UPDATE chunks SET data = ?, crc = ? WHERE id = ?", (packed, zlib.crc32(packed), number))
    return int(number)


def _add(connection: sqlite3.Connection, entry: bytes, version: bytes, code: bytes, scope: int) -> int:
    packed = pack(code)
    insert = "INSERT INTO chunks (scope, waypoints, data, plans, crc) VALUES (?, ?, ?, x'', ?) RETURNING id"
    values = scope, waypoints_in(code), packed, zlib.crc32(packed)
    [number] = connection.execute(insert, values).fetchone()
    connection.execute("INSERT INTO chunk_ids VALUES (?, ?)", (entry, number))
    connection.execute("INSERT INTO chunk_refs VALUES (?, 0)", (number,))
    places = _places(version, code, number)
    connection.executemany("INSERT OR IGNORE INTO chunk_places VALUES (?, ?)", places)
    return int(number)


def remove_segment(connection: sqlite3.Connection, number: int, version: bytes) -> None:
    """Remove a segment of a map version; one that cannot be read is searched for in the indexes."""
    data, crc = connection.execute("SELECT data, crc FROM chunks WHERE id = ?", (number,)).fetchone()
    connection.execute("DELETE FROM chunks WHERE id = ?", (number,))
    connection.execute("DELETE FROM chunk_refs WHERE chunk = ?", (number,))
    try:
        code = unpack(data) if is_intact(data, crc) else None
    except PPaaSError:
        code = None
    if code is None:
        connection.execute("DELETE FROM chunk_ids WHERE chunk = ?", (number,))
        connection.execute("DELETE FROM chunk_places WHERE chunk = ?", (number,))
        return
    connection.execute("DELETE FROM chunk_ids WHERE entry = ?", (entry_id(version, code),))
    places = _places(version, code, number)
    connection.executemany("DELETE FROM chunk_places WHERE place = ? AND chunk = ?", places)


def segment_faults(connection: sqlite3.Connection) -> Iterator[str]:
    """Yield the segments whose content is not the one of their hash."""
    query = """SELECT chunk, entry, data, map, version FROM chunk_ids JOIN chunks ON chunks.id = chunk
               JOIN scopes ON scopes.id = scope ORDER BY chunk"""
    for number, entry, data, map_id, version in connection.execute(query):
        try:
            is_right = entry_id(scope_of(map_id, version), unpack(data)) == entry
        except PPaaSError:
            is_right = False
        if not is_right:
            yield f"chunks/{number} is damaged (a segment of plans of map {map_id}): restore it from a backup"


def _places(version: bytes, code: bytes, number: int) -> list[tuple[int, int]]:
    return [(cell_number(version, cell), number) for cell in cells_touched(poses_of(code)[:, :2])]
