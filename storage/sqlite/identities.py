"""Index of users by their identity at a provider, in SQLite.

The triggers note each user that is written. A look-up reads those beside the index, and indexes them. So the index is
complete whatever writes to the file: also an earlier release, which another process of the cloud may still run.
"""

from contextlib import suppress
from sqlite3 import Connection

from ppaas.errors import NotFound, Unavailable
from storage.encoding import decode_readable
from storage.records import User
from storage.sharing_records import ProvidedIdentity
from storage.sqlite.connections import SqliteConnections

_READ = """SELECT record, 'users/' || id, id IN (SELECT user FROM unindexed_users) FROM users
           WHERE id IN (SELECT user FROM unindexed_users)
           OR id IN (SELECT user FROM identities WHERE issuer = ? AND subject = ?) ORDER BY id"""

_UNINDEXED = "SELECT record, 'users/' || id FROM users JOIN unindexed_users ON id = user"


class SqliteIdentities:
    """Finds users by their identity.

    Parameters
    ----------
    connections : SqliteConnections
        Connections to the file.
    """

    def __init__(self, connections: SqliteConnections) -> None:
        self._identity_connections = connections

    def user_with_identity(self, identity: ProvidedIdentity) -> User:
        """Return the user of an identity; ``NotFound`` if none has it."""
        with self._identity_connections.reading() as connection:
            rows = connection.execute(_READ, (identity.issuer, identity.subject)).fetchall()
        placed = ((record, place) for record, place, _ in rows)
        found = [user for user in decode_readable(placed, User) if user.identity == identity]
        if any(is_new for _, _, is_new in rows):
            with suppress(Unavailable):  # on a full disk; a later look-up indexes them
                self._index()
        if not found:
            raise NotFound("user of identity", identity.subject)
        return found[0]

    def _index(self) -> None:
        with self._identity_connections.writing() as connection:
            _index(connection)


def _index(connection: Connection) -> None:
    """Index the users that were written since."""
    rows = connection.execute(_UNINDEXED).fetchall()
    connection.execute("DELETE FROM identities WHERE user IN (SELECT user FROM unindexed_users)")
    users = [(user.id, user.identity) for user in decode_readable(rows, User)]
    entries = [(one.issuer, one.subject, user) for user, one in users if one is not None]
    connection.executemany("INSERT OR IGNORE INTO identities VALUES (?, ?, ?)", entries)
    connection.execute("DELETE FROM unindexed_users")
