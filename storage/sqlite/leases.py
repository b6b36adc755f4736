"""Leases in an SQLite file, for candidates on one host."""

from storage.names import check_name
from storage.records import Lease, check_lease
from storage.sqlite.connections import SqliteConnections

_FIRST = "INSERT INTO leases (name, holder, epoch, beat) VALUES (?, ?, ?, ?) ON CONFLICT DO NOTHING"

_CHANGE = """UPDATE leases SET holder = ?, epoch = ?, beat = ?
             WHERE name = ? AND holder = ? AND epoch = ? AND beat = ?"""


class SqliteLeases:
    """A ``LeaseStore`` in an SQLite file.

    Parameters
    ----------
    connections : SqliteConnections
        Connections to the file.
    """

    def __init__(self, connections: SqliteConnections) -> None:
        self._lease_connections = connections

    def lease(self, name: str) -> Lease:
        """Return a lease; one of epoch 0 without a holder if it was never taken."""
        query = "SELECT holder, epoch, beat FROM leases WHERE name = ?"
        with self._lease_connections.reading() as connection:
            row = connection.execute(query, (check_name("lease", name),)).fetchone()
        return Lease(name) if row is None else Lease(name, *row)

    def change_lease(self, lease: Lease, *, instead_of: Lease) -> bool:
        """Store a lease if the stored one is ``instead_of``; return whether it was.

        A beat is not synced: all candidates are on this host, and end with it when its power fails.
        """
        check_lease(lease, instead_of)
        new, old = _values(lease), _values(instead_of)
        with self._lease_connections.writing(synced=lease.epoch != instead_of.epoch) as connection:
            first = instead_of == Lease(lease.name) and connection.execute(_FIRST, (lease.name, *new)).rowcount
            return bool(first or connection.execute(_CHANGE, (*new, lease.name, *old)).rowcount)


def _values(lease: Lease) -> tuple[str, int, int]:
    return lease.holder, lease.epoch, lease.beat
