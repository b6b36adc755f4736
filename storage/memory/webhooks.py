"""Webhooks in memory."""

import threading

from ppaas.errors import NotFound
from storage.names import check_delivery_key, check_name, check_webhook_key
from storage.webhooks.records import Webhook, WebhookDelivery, no_webhook


class MemoryWebhooks:
    """A ``WebhookStore`` of dictionaries."""

    def __init__(self) -> None:
        self._webhooks_lock = threading.Lock()
        self._webhooks: dict[tuple[str, str], Webhook] = {}
        self._deliveries: dict[tuple[str, str], dict[str, WebhookDelivery]] = {}

    def put_webhook(self, record: Webhook, *, instead_of: Webhook | None = None) -> None:
        """Store a webhook; ``Conflict`` if the stored one is not ``instead_of``."""
        key = check_webhook_key(*record.key)
        with self._webhooks_lock:
            if instead_of is not None and self._webhooks.get(key) != instead_of:
                raise record.changed_meanwhile()
            self._webhooks[key] = record

    def webhook(self, user: str, hook: str) -> Webhook:
        """Return a webhook; ``NotFound`` if it does not exist."""
        key = check_webhook_key(user, hook)
        with self._webhooks_lock:
            if key not in self._webhooks:
                raise no_webhook(hook)
            return self._webhooks[key]

    def webhooks(self, user: str, *, after: str = "", limit: int | None = None) -> list[Webhook]:
        """Return the webhooks of a user, sorted by id."""
        check_name("user", user)
        with self._webhooks_lock:
            found = sorted(key for key in self._webhooks if key[0] == user and key[1] > after)[:limit]
            return [self._webhooks[key] for key in found]

    def webhook_users(self) -> list[str]:
        """Return the users who have webhooks, sorted."""
        with self._webhooks_lock:
            return sorted({user for user, _ in self._webhooks})

    def remove_webhook(self, user: str, hook: str) -> None:
        """Remove a webhook with its deliveries; ``NotFound`` if it does not exist."""
        key = check_webhook_key(user, hook)
        with self._webhooks_lock:
            if self._webhooks.pop(key, None) is None:
                raise no_webhook(hook)
            self._deliveries.pop(key, None)

    def put_delivery(self, record: WebhookDelivery) -> None:
        """Store a delivery; ``NotFound`` if its webhook does not exist."""
        *hook, name = check_delivery_key(*record.key)
        with self._webhooks_lock:
            if tuple(hook) not in self._webhooks:
                raise no_webhook(record.hook)
            self._deliveries.setdefault((record.user, record.hook), {})[name] = record

    def delivery(self, user: str, hook: str, delivery: str) -> WebhookDelivery:
        """Return a delivery; ``NotFound`` if it does not exist."""
        check_delivery_key(user, hook, delivery)
        with self._webhooks_lock:
            found = self._deliveries.get((user, hook), {}).get(delivery)
        if found is None:
            raise NotFound("delivery", delivery)
        return found

    def deliveries(self, user: str, hook: str, *, after: str = "", limit: int | None = None) -> list[WebhookDelivery]:
        """Return the deliveries of a webhook, sorted by id."""
        with self._webhooks_lock:
            rows = self._deliveries.get(check_webhook_key(user, hook), {})
            return [rows[name] for name in sorted(name for name in rows if name > after)[:limit]]

    def remove_delivery(self, user: str, hook: str, delivery: str) -> None:
        """Remove a delivery, if it exists."""
        check_delivery_key(user, hook, delivery)
        with self._webhooks_lock:
            self._deliveries.get((user, hook), {}).pop(delivery, None)

    def _forget_webhooks(self, user: str) -> None:
        """Remove the webhooks of a user."""
        with self._webhooks_lock:
            self._webhooks = {key: record for key, record in self._webhooks.items() if key[0] != user}
            self._deliveries = {key: rows for key, rows in self._deliveries.items() if key[0] != user}
