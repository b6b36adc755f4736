"""Everything but maps in Cassandra, for several cloud hosts and for data that survives the loss of any of them."""

from ppaas.plans.encoding.granularity import inner_granularity
from storage.cassandra.accounts import CassandraAccounts
from storage.cassandra.connection.address import parse_address
from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.history import CassandraHistory
from storage.cassandra.leases import CassandraLeases
from storage.cassandra.people import CassandraPeople
from storage.cassandra.plans.sweep import CassandraSweep
from storage.cassandra.robots import CassandraRobots
from storage.cassandra.tasks import CassandraTasks


class CassandraStore(
    CassandraAccounts,
    CassandraRobots,
    CassandraHistory,
    CassandraPeople,
    CassandraTasks,
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
