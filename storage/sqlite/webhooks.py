"""Webhooks in an SQLite file."""

from ppaas.errors import NotFound
from storage.encoding import decode, decode_readable, encode
from storage.names import check_delivery_key, check_name, check_webhook_key
from storage.sqlite.connections import SqliteConnections
from storage.webhooks.records import Webhook, WebhookDelivery, no_webhook

_HOOK_PLACE = "'webhooks/' || user || '/' || id"
_HOOK = f"SELECT record, {_HOOK_PLACE} FROM webhooks WHERE user = ? AND id = ?"
_DELIVERY_PLACE = "'webhook_deliveries/' || user || '/' || hook || '/' || id"
_OF_HOOK = f"SELECT record, {_DELIVERY_PLACE} FROM webhook_deliveries WHERE user = ? AND hook = ?"
_PUT_DELIVERY = """INSERT OR REPLACE INTO webhook_deliveries
                   SELECT user, id, ?, ? FROM webhooks WHERE user = ? AND id = ?"""


class SqliteWebhooks:
    """A ``WebhookStore`` in an SQLite file.

    Parameters
    ----------
    connections : SqliteConnections
        Connections to the file.
    """

    def __init__(self, connections: SqliteConnections) -> None:
        self._webhook_connections = connections

    def put_webhook(self, record: Webhook, *, instead_of: Webhook | None = None) -> None:
        """Store a webhook; ``Conflict`` if the stored one is not ``instead_of``."""
        key, data = check_webhook_key(*record.key), encode(record)
        with self._webhook_connections.writing() as connection:
            row = connection.execute(_HOOK, key).fetchone()
            if instead_of is not None and (row is None or decode(row[0], Webhook, row[1]) != instead_of):
                raise record.changed_meanwhile()
            connection.execute("INSERT OR REPLACE INTO webhooks VALUES (?, ?, ?)", (*key, data))

    def webhook(self, user: str, hook: str) -> Webhook:
        """Return a webhook; ``NotFound`` if it does not exist."""
        key = check_webhook_key(user, hook)
        with self._webhook_connections.reading() as connection:
            row = connection.execute(_HOOK, key).fetchone()
        if row is None:
            raise no_webhook(hook)
        return decode(row[0], Webhook, row[1])

    def webhooks(self, user: str, *, after: str = "", limit: int | None = None) -> list[Webhook]:
        """Return the webhooks of a user, sorted by id."""
        query = f"SELECT record, {_HOOK_PLACE} FROM webhooks WHERE user = ? AND id > ? ORDER BY id"
        with self._webhook_connections.reading() as connection:
            return decode_readable(connection.execute(query, (check_name("user", user), after)), Webhook, limit)

    def webhook_users(self) -> list[str]:
        """Return the users who have webhooks, sorted."""
        with self._webhook_connections.reading() as connection:
            return [user for (user,) in connection.execute("SELECT DISTINCT user FROM webhooks ORDER BY user")]

    def remove_webhook(self, user: str, hook: str) -> None:
        """Remove a webhook with its deliveries; ``NotFound`` if it does not exist."""
        key = check_webhook_key(user, hook)
        with self._webhook_connections.writing() as connection:
            if not connection.execute("DELETE FROM webhooks WHERE user = ? AND id = ?", key).rowcount:
                raise no_webhook(hook)
            connection.execute("DELETE FROM webhook_deliveries WHERE user = ? AND hook = ?", key)

    def put_delivery(self, record: WebhookDelivery) -> None:
        """Store a delivery; ``NotFound`` if its webhook does not exist."""
        user, hook, name = check_delivery_key(*record.key)
        with self._webhook_connections.writing() as connection:
            if not connection.execute(_PUT_DELIVERY, (name, encode(record), user, hook)).rowcount:
                raise no_webhook(hook)

    def delivery(self, user: str, hook: str, delivery: str) -> WebhookDelivery:
        """Return a delivery; ``NotFound`` if it does not exist."""
        key = check_delivery_key(user, hook, delivery)
        with self._webhook_connections.reading() as connection:
            row = connection.execute(f"{_OF_HOOK} AND id = ?", key).fetchone()
        if row is None:
            raise NotFound("delivery", delivery)
        return decode(row[0], WebhookDelivery, row[1])

    def deliveries(self, user: str, hook: str, *, after: str = "", limit: int | None = None) -> list[WebhookDelivery]:
        """Return the deliveries of a webhook, sorted by id."""
        with self._webhook_connections.reading() as connection:
            rows = connection.execute(f"{_OF_HOOK} AND id > ? ORDER BY id", (*check_webhook_key(user, hook), after))
            return decode_readable(rows, WebhookDelivery, limit)

    def remove_delivery(self, user: str, hook: str, delivery: str) -> None:
        """Remove a delivery, if it exists."""
        key = check_delivery_key(user, hook, delivery)
        with self._webhook_connections.writing() as connection:
            connection.execute("DELETE FROM webhook_deliveries WHERE user = ? AND hook = ? AND id = ?", key)
