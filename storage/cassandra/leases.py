"""Leases in Cassandra, which are read and written by lightweight transactions over all data centres."""

from storage.cassandra.connection.session import CassandraSession
from storage.names import check_name
from storage.records import Lease, check_lease

_FIRST = "INSERT INTO leases (name, holder, epoch, beat) VALUES (?, ?, ?, ?) IF NOT EXISTS"

_CHANGE = "UPDATE leases SET holder = ?, epoch = ?, beat = ? WHERE name = ? IF holder = ? AND epoch = ? AND beat = ?"


class CassandraLeases:
    """A ``LeaseStore`` in Cassandra."""

    _session: CassandraSession

    def lease(self, name: str) -> Lease:
        """Return a lease; one of epoch 0 without a holder if it was never taken."""
        query = "SELECT holder, epoch, beat FROM leases WHERE name = ?"
        row = self._session.serial_row(query, check_name("lease", name))
        return Lease(name) if row is None else Lease(name, row.holder, row.epoch, row.beat)

    def change_lease(self, lease: Lease, *, instead_of: Lease) -> bool:
        """Store a lease if the stored one is ``instead_of``; return whether it was."""
        check_lease(lease, instead_of)
        values = lease.holder, lease.epoch, lease.beat
        if instead_of == Lease(lease.name) and self._session.serial_write_if(_FIRST, lease.name, *values):
            return True
        old = instead_of.holder, instead_of.epoch, instead_of.beat
        return self._session.serial_write_if(_CHANGE, *values, lease.name, *old)
