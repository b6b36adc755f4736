"""Webhooks in Cassandra: those of a user are a partition, and the deliveries of each are one."""

from ppaas.errors import NotFound
from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.sorted_rows import SortedRows, generation_of, remove_marked
from storage.encoding import decode, decode_readable, encode
from storage.names import check_delivery_key, check_name, check_webhook_key
from storage.webhooks.records import Webhook, WebhookDelivery, no_webhook

_OF_USER = "user = ? AND generation = ?"
_HOOKS = SortedRows("webhooks", _OF_USER, "id", "generation DESC, id DESC", "record")
_PUT_HOOK = f"UPDATE webhooks SET record = ? WHERE {_OF_USER} AND id = ? IF record = ?"

_OF_HOOK = "user = ? AND hook = ? AND generation = ?"
_DELIVERIES = SortedRows("webhook_deliveries", _OF_HOOK, "id", "generation DESC, id DESC", "record")
_PUT_DELIVERY = f"UPDATE webhook_deliveries SET record = ? WHERE {_OF_HOOK} AND id = ? IF record = ?"


class CassandraWebhooks:
    """A ``WebhookStore`` in Cassandra.

    A removal first empties the record, and then deletes the row (``storage.cassandra.sorted_rows``). Deliveries are of
    webhooks that exist: those that were stored while their webhook was removed are never read.
    """

    _session: CassandraSession

    # -- webhooks ------------------------------------------------------------------------------------------------------

    def put_webhook(self, record: Webhook, *, instead_of: Webhook | None = None) -> None:
        """Store a webhook; ``Conflict`` if the stored one is not ``instead_of``."""
        user, hook = check_webhook_key(*record.key)
        group, data = self._webhook_group(user), encode(record)
        while True:
            before = self._webhook_record(group, hook)
            if instead_of is not None and (
                not before or decode(before, Webhook, f"webhooks/{user}/{hook}") != instead_of
            ):
                raise record.changed_meanwhile()
            if self._session.write_if(_PUT_HOOK, data, *group, hook, before):
                return

    def webhook(self, user: str, hook: str) -> Webhook:
        """Return a webhook; ``NotFound`` if it does not exist."""
        check_webhook_key(user, hook)
        data = self._webhook_record(self._webhook_group(user), hook)
        if not data:
            raise no_webhook(hook)
        return decode(data, Webhook, f"webhooks/{user}/{hook}")

    def webhooks(self, user: str, *, after: str = "", limit: int | None = None) -> list[Webhook]:
        """Return the webhooks of a user, sorted by id."""
        query = f"SELECT id, record FROM webhooks WHERE {_OF_USER} AND id > ?"
        rows = self._session.rows(query, *self._webhook_group(check_name("user", user)), after)
        return decode_readable(
            ((row.record, f"webhooks/{user}/{row.id}") for row in rows if row.record), Webhook, limit
        )

    def webhook_users(self) -> list[str]:
        """Return the users who have webhooks, sorted."""
        return [user for user in self._session.partitions("webhooks", "user") if self.webhooks(user, limit=1)]

    def remove_webhook(self, user: str, hook: str) -> None:
        """Remove a webhook with its deliveries; ``NotFound`` if it does not exist."""
        check_webhook_key(user, hook)
        group = self._webhook_group(user)
        while before := self._webhook_record(group, hook):
            if self._session.write_if(_PUT_HOOK, b"", *group, hook, before):
                self._session.write("DELETE FROM webhook_deliveries WHERE user = ? AND hook = ?", user, hook)
                remove_marked(self._session, _HOOKS, group, hook)
                return
        raise no_webhook(hook)

    # -- deliveries ----------------------------------------------------------------------------------------------------

    def put_delivery(self, record: WebhookDelivery) -> None:
        """Store a delivery; ``NotFound`` if its webhook does not exist."""
        user, hook, name = check_delivery_key(*record.key)
        group, data = self._delivery_group(user, hook), encode(record)
        while self._webhook_record((user, group[2]), hook):
            if self._session.write_if(_PUT_DELIVERY, data, *group, name, self._delivery_record(group, name)):
                return
        raise no_webhook(hook)

    def delivery(self, user: str, hook: str, delivery: str) -> WebhookDelivery:
        """Return a delivery; ``NotFound`` if it does not exist."""
        check_delivery_key(user, hook, delivery)
        data = self._delivery_record(self._delivery_group(user, hook), delivery)
        if not data:
            raise NotFound("delivery", delivery)
        return decode(data, WebhookDelivery, f"webhook_deliveries/{user}/{hook}/{delivery}")

    def deliveries(self, user: str, hook: str, *, after: str = "", limit: int | None = None) -> list[WebhookDelivery]:
        """Return the deliveries of a webhook, sorted by id."""
        check_webhook_key(user, hook)
        query = f"SELECT id, record FROM webhook_deliveries WHERE {_OF_HOOK} AND id > ?"
        rows = self._session.rows(query, *self._delivery_group(user, hook), after)
        placed = ((row.record, f"webhook_deliveries/{user}/{hook}/{row.id}") for row in rows if row.record)
        return decode_readable(placed, WebhookDelivery, limit)

    def remove_delivery(self, user: str, hook: str, delivery: str) -> None:
        """Remove a delivery, if it exists."""
        check_delivery_key(user, hook, delivery)
        group = self._delivery_group(user, hook)
        while before := self._delivery_record(group, delivery):
            if self._session.write_if(_PUT_DELIVERY, b"", *group, delivery, before):
                remove_marked(self._session, _DELIVERIES, group, delivery)
                return

    # -- internals -----------------------------------------------------------------------------------------------------

    def _sweep_webhooks(self, user: str, generation: int) -> None:
        """Delete the webhooks of a former user of an id."""
        rows = list(self._session.rows(f"SELECT id FROM webhooks WHERE {_OF_USER}", user, generation))
        for row in rows:
            self._session.write("DELETE FROM webhook_deliveries WHERE user = ? AND hook = ?", user, row.id)
        if rows:
            self._session.write(f"DELETE FROM webhooks WHERE {_OF_USER}", user, generation)

    def _webhook_group(self, user: str) -> tuple[str, int]:
        return user, generation_of(self._session, user)

    def _delivery_group(self, user: str, hook: str) -> tuple[str, str, int]:
        return user, hook, generation_of(self._session, user)

    def _webhook_record(self, group: tuple[str, int], hook: str) -> bytes | None:
        row = self._session.row(f"SELECT record FROM webhooks WHERE {_OF_USER} AND id = ?", *group, hook)
        return None if row is None else row.record

    def _delivery_record(self, group: tuple[str, str, int], name: str) -> bytes | None:
        row = self._session.row(f"SELECT record FROM webhook_deliveries WHERE {_OF_HOOK} AND id = ?", *group, name)
        return None if row is None else row.record
