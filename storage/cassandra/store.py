"""Everything but maps in Cassandra: for more than one machine, and for data that outlives any of them."""

from ppaas.plans.encoding.chunks import inner_granularity
from storage.cassandra.accounts import CassandraAccounts
from storage.cassandra.connection.address import parse_address
from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.history import CassandraHistory
from storage.cassandra.plans.sweep import CassandraSweep
from storage.cassandra.robots import CassandraRobots


class CassandraStore(CassandraAccounts, CassandraRobots, CassandraHistory, CassandraSweep):
    """A ``Store`` in a keyspace of a Cassandra, which any number of processes may have open.

    It is connected to when it is asked for the first time, so that it may be away when the cloud starts.

    Parameters
    ----------
    url : str
        Where it is (``storage.cassandra.connection.address``). The keyspace and its tables are made where they are
        missing.

    Raises
    ------
    InvalidInput
        The URL says something else.
    """

    def __init__(self, url: str) -> None:
        address = parse_address(url)
        self._session = CassandraSession(address)
        self._granularity = inner_granularity(address.granularity)

    def close(self) -> None:
        """Let go of the connections."""
        self._session.close()

    def remove_user(self, user_id: str) -> None:
        """Remove a user with all tokens, robots and checkpoints; ``NotFound`` if it does not exist."""
        generation = self._end_generation(user_id)
        self._sweep_tokens(user_id)
        self._sweep_robots(user_id, generation)
