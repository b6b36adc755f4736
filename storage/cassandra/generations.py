"""Generations of users (``storage.cassandra.connection.schema``)."""

from storage.cassandra.connection.session import CassandraSession


def generation_of(session: CassandraSession, user: str) -> int:
    """Return the generation under which the rows of a user are valid; 0 for a user who never existed."""
    row = session.row("SELECT generation FROM users WHERE shard = 0 AND id = ?", user)
    return 0 if row is None else row.generation or 0
