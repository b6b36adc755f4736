"""Messages of webhooks: which events a webhook wants, their JSON, secrets and signatures.

Headers and signatures follow the convention of Standard Webhooks.
"""

import base64
import datetime
import hmac
import secrets
from collections.abc import Mapping

import msgspec

from engine.control.fleet_events import FleetEvent
from engine.rights.globs import matches
from ppaas import __version__
from storage.webhooks.records import Webhook, WebhookDelivery

TEST = "webhook.test"
"""Type of the event that a user sends to try a webhook."""

SECRET = "whsec_"
"""Beginning of secrets, as users see them."""

SECRET_BYTES = 32
"""Size of a secret [bytes]."""

MAX_BODY = 16 << 10
"""Limit of the body of a delivery [bytes]: a webhook has up to 1000 that wait, and as many dead ones."""

OVERLAP = 24 * 3600.0
"""Time for which the secret before a new one stays valid [s]."""


def wants(hook: Webhook, event: FleetEvent) -> bool:
    """Return whether an event is for a webhook; an event without a robot or a map passes no filter by these."""
    return (
        hook.state != "disabled"
        and matches(event.type, hook.events)
        and (not hook.robots or matches(event.robot, hook.robots))
        and (not hook.maps or matches(event.map, hook.maps))
    )


def new_delivery(hook: Webhook, event: FleetEvent) -> WebhookDelivery:
    """Return the delivery of an event to a webhook, due now."""
    name = f"msg_{int(event.time * 1000.0):012x}-{secrets.token_hex(4)}"
    return WebhookDelivery(
        user=hook.user, hook=hook.id, id=name, event=event.type, body=body_of(event), created=event.time, due=event.time
    )


def body_of(event: FleetEvent) -> bytes:
    """Return an event as JSON; beyond `MAX_BODY`, with the names of its details in ``omitted`` instead of them."""
    about = {name: value for name in ("user", "robot", "map") if (value := getattr(event, name))}
    at = datetime.datetime.fromtimestamp(event.time, datetime.UTC).isoformat(timespec="milliseconds")
    whole = {"type": event.type, "timestamp": at.replace("+00:00", "Z"), "data": about | event.data}
    body = msgspec.json.encode(whole)
    if len(body) <= MAX_BODY:
        return body
    return msgspec.json.encode(whole | {"data": about | {"omitted": sorted(event.data)}})


def new_secret() -> bytes:
    """Return a new secret."""
    return secrets.token_bytes(SECRET_BYTES)


def shown_secret(secret: bytes) -> str:
    """Return a secret as its user keeps it."""
    return SECRET + base64.b64encode(secret).decode()


def headers_of(hook: Webhook, delivery: WebhookDelivery, now: float) -> Mapping[str, str]:
    """Return the headers of an attempt at a time [s since the epoch], signed with each secret that is valid then."""
    keys = [hook.secret, *([hook.former_secret] if now < hook.former_until else [])]
    signed = f"{delivery.id}.{int(now)}.".encode() + delivery.body
    signatures = (base64.b64encode(hmac.digest(key, signed, "sha256")).decode() for key in keys)
    return {
        "Content-Type": "application/json",
        "User-Agent": f"PPaaS/{__version__}",
        "webhook-id": delivery.id,
        "webhook-timestamp": str(int(now)),
        "webhook-signature": " ".join(f"v1,{signature}" for signature in signatures),
    }
