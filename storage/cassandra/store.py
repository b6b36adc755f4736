"""Everything but maps in Cassandra, for several cloud hosts and for data that survives the loss of any of them."""

from collections.abc import Iterator

import msgspec

from ppaas.plans.encoding.granularity import inner_granularity
from ppaas.plans.history import LinkHistory, PlannerHistory
from storage.buildings.records import BuildingRecord
from storage.cassandra.accounts import CassandraAccounts
from storage.cassandra.buildings import CassandraBuildings
from storage.cassandra.connection.address import parse_address
from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.history import CassandraHistory
from storage.cassandra.people import CassandraPeople
from storage.cassandra.plans.sweep import CassandraSweep
from storage.cassandra.robots import CassandraRobots
from storage.cassandra.tasks import CassandraTasks
from storage.cassandra.webhooks import CassandraWebhooks
from storage.names import check_name
from storage.people import MapPeople
from storage.records import CloneCheckpoint, Lease, MapTask, PlanStatistics, RobotRecord, Token, User, check_lease
from storage.webhooks.records import Webhook, WebhookDelivery

# Leases are read and written by lightweight transactions over all data centres.

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


_RECORDS: dict[str, tuple[type[msgspec.Struct], tuple[str, ...]]] = {
    "users": (User, ("id",)),
    "tokens": (Token, ("hash",)),
    "robots": (RobotRecord, ("user", "id")),
    "clones": (CloneCheckpoint, ("user", "robot")),
    "people": (MapPeople, ("map", "user")),
    "tasks": (MapTask, ("user", "map", "id")),
    "buildings": (BuildingRecord, ("user", "id")),
    "webhooks": (Webhook, ("user", "id")),
    "webhook_deliveries": (WebhookDelivery, ("user", "hook", "id")),
    "history": (PlannerHistory, ("map", "version", "planner", "bucket")),
    "links": (LinkHistory, ("link",)),
    "plan_sums": (PlanStatistics, ("map", "writer")),
}
"""Tables of records, with the kind and the key of each."""


class CassandraStore(
    CassandraAccounts,
    CassandraRobots,
    CassandraHistory,
    CassandraPeople,
    CassandraTasks,
    CassandraBuildings,
    CassandraWebhooks,
    CassandraLeases,
    CassandraSweep,
):
    """A ``Store`` in a Cassandra keyspace, which any number of processes may use at once.

    It connects with the first request, so the cluster may be down when the cloud starts.

    Parameters
    ----------
    url : str
        URL of the keyspace (``storage.cassandra.connection.address``). The keyspace and its tables are created if they
        are missing.
    create : bool
        Whether to create the keyspace if it is missing; otherwise requests raise ``Unavailable``.

    Raises
    ------
    InvalidInput
        The URL is not valid.
    """

    def __init__(self, url: str, *, create: bool = True) -> None:
        address = parse_address(url)
        self._session = CassandraSession(address, create=create)
        self._granularity = inner_granularity(address.granularity)

    def all_records(self) -> Iterator[tuple[bytes, type[msgspec.Struct], str]]:
        """Yield all records with their kinds and places, damaged ones included; plans are not among them."""
        for table, (kind, keys) in _RECORDS.items():
            for row in self._session.rows(f"SELECT {', '.join(keys)}, record FROM {table}"):
                if row.record:
                    yield row.record, kind, "/".join((table, *(str(getattr(row, key)) for key in keys)))

    def close(self) -> None:
        """Close the connections."""
        self._session.close()

    def remove_user(self, user_id: str) -> None:
        """Remove a user with all that belongs to it; ``NotFound`` if it does not exist."""
        generation = self._end_generation(user_id)
        self._sweep_tokens(user_id)
        self._sweep_robots(user_id, generation)
        self._sweep_people(user_id, generation)
        self._sweep_tasks(user_id, generation)
        self._sweep_buildings(user_id, generation)
        self._sweep_webhooks(user_id, generation)
