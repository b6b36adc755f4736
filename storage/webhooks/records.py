"""Webhooks and their deliveries: records, and the port of stores of them.

The port follows the rules of ``storage.ports``.
"""

from typing import Literal, Protocol

import msgspec

from ppaas.errors import Conflict, NotFound

WebhookState = Literal["enabled", "paused", "disabled"]
"""``paused``: deliveries wait. ``disabled``: events are not delivered, as the target has answered that it is gone."""

DeliveryState = Literal["waiting", "dead"]
"""``dead``: it is not tried any more, unless it is replayed."""


class Webhook(msgspec.Struct, frozen=True, kw_only=True):
    """A webhook of a user: where events are sent, and which.

    Parameters
    ----------
    user, id : str
    url : str
        Target of the deliveries.
    events : tuple of str
        Types of events, or globs of them.
    robots, maps : tuple of str
        Globs of the robots and maps whose events are sent; none for all.
    description : str
    state : WebhookState
    reason : str
        Why it is disabled.
    secret : bytes
        Key of the signatures.
    former_secret : bytes
        Key before it, by which deliveries are signed too until ``former_until`` [s since the epoch].
    former_until : float
    created : float
        [s since the epoch]
    """

    user: str
    id: str
    url: str
    events: tuple[str, ...]
    robots: tuple[str, ...] = ()
    maps: tuple[str, ...] = ()
    description: str = ""
    state: WebhookState = "enabled"
    reason: str = ""
    secret: bytes = b""
    former_secret: bytes = b""
    former_until: float = 0.0
    created: float = 0.0

    @property
    def key(self) -> tuple[str, str]:
        """User and id."""
        return self.user, self.id

    def changed_meanwhile(self) -> Conflict:
        """Return the error of a webhook that another process changed first."""
        return Conflict(f"webhook {self.id!r} has been changed meanwhile: read it again and retry")


class WebhookDelivery(msgspec.Struct, frozen=True, kw_only=True):
    """An event for a webhook that was not delivered yet.

    Parameters
    ----------
    user, hook : str
        User and id of the webhook.
    id : str
        Ids rise with the time of the event.
    event : str
        Type of the event.
    body : bytes
        What is sent.
    created : float
        Time of the event [s since the epoch], as all times.
    state : DeliveryState
    attempts : int
        Number of attempts since it was created or replayed.
    due : float
        Time of the next attempt.
    reason : str
        Why the last attempt failed.
    ended : float, optional
        Time at which it was given up.
    """

    user: str
    hook: str
    id: str
    event: str
    body: bytes
    created: float
    state: DeliveryState = "waiting"
    attempts: int = 0
    due: float = 0.0
    reason: str = ""
    ended: float | None = None

    @property
    def key(self) -> tuple[str, str, str]:
        """User, id of the webhook, id."""
        return self.user, self.hook, self.id


def no_webhook(hook: str) -> NotFound:
    """Return the error of a webhook that does not exist."""
    return NotFound("webhook", hook)


class WebhookStore(Protocol):
    """Webhooks of users, and their deliveries, which come and go."""

    def put_webhook(self, record: Webhook, *, instead_of: Webhook | None = None) -> None:
        """Store a webhook.

        Raises
        ------
        Conflict
            ``instead_of`` is given and differs from the stored record: another process changed it first.
        """
        ...

    def webhook(self, user: str, hook: str) -> Webhook:
        """Return a webhook; ``NotFound`` if it does not exist."""
        ...

    def webhooks(self, user: str, *, after: str = "", limit: int | None = None) -> list[Webhook]:
        """Return the webhooks of a user, sorted by id."""
        ...

    def webhook_users(self) -> list[str]:
        """Return the users who have webhooks, sorted."""
        ...

    def remove_webhook(self, user: str, hook: str) -> None:
        """Remove a webhook with its deliveries; ``NotFound`` if it does not exist. Its id is never used again."""
        ...

    def put_delivery(self, record: WebhookDelivery) -> None:
        """Store a delivery, in place of the one with its id; ``NotFound`` if its webhook does not exist."""
        ...

    def delivery(self, user: str, hook: str, delivery: str) -> WebhookDelivery:
        """Return a delivery; ``NotFound`` if it does not exist."""
        ...

    def deliveries(self, user: str, hook: str, *, after: str = "", limit: int | None = None) -> list[WebhookDelivery]:
        """Return the deliveries of a webhook, sorted by id."""
        ...

    def remove_delivery(self, user: str, hook: str, delivery: str) -> None:
        """Remove a delivery, if it exists."""
        ...
