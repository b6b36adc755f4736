"""JSON schemas of webhooks and of their deliveries."""

from typing import Annotated, Literal

from pydantic import AfterValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

from endpoints.rest.schemas import Description, RequestBody, ResponseBody
from endpoints.webhooks.messages import shown_secret
from endpoints.webhooks.targets import MAX_URL
from engine.control.fleet_events import EVENT_TYPES
from engine.rights.globs import matches
from storage.webhooks.records import DeliveryState, Webhook, WebhookDelivery, WebhookState

MAX_EVENTS = 32
"""Limit of the types of events of a webhook, and of its globs of robots and maps."""

_NAME_GLOB = r"^[A-Za-z0-9_.*?\[\]!-]{1,64}$"


def _event(text: str) -> str:
    if not any(matches(known, [text]) for known in EVENT_TYPES):
        message = "{shown} is no type of events and no glob of them: {known}"
        raise PydanticCustomError("event", message, {"shown": repr(text), "known": ", ".join(EVENT_TYPES)})
    return text


EventGlob = Annotated[str, Field(pattern=r"^[a-z_.*]{1,64}$"), AfterValidator(_event)]
Events = Annotated[
    list[EventGlob],
    Field(min_length=1, max_length=MAX_EVENTS, description="Types of events, or globs of them, such as `goal.*`"),
]
Globs = Annotated[
    list[Annotated[str, Field(pattern=_NAME_GLOB)]], Field(max_length=MAX_EVENTS, description="Globs; empty for all")
]
Url = Annotated[str, Field(min_length=1, max_length=MAX_URL, description="Target, `https://…`")]
ChosenState = Literal["enabled", "paused"]


class WebhookFile(RequestBody):
    """Webhook to create."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"url": "https://example.org/robots", "events": ["goal.*", "robot.lost"]}]}
    )

    url: Url
    events: Events
    robots: Globs = Field([])
    maps: Globs = Field([])
    description: Description = ""
    state: ChosenState = "enabled"


class WebhookChange(RequestBody):
    """Fields of a webhook to change (RFC 7396)."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"state": "paused"}]})

    url: Url | None = None
    events: Events | None = None
    robots: Globs | None = None
    maps: Globs | None = None
    description: Description | None = None
    state: ChosenState | None = None


class WebhookAnswer(ResponseBody):
    """Webhook, without its secret."""

    id: str
    url: str
    events: list[str]
    robots: list[str]
    maps: list[str]
    description: str
    state: WebhookState = Field(
        description="`paused`: deliveries wait; `disabled`: the target answered 410, and events are dropped"
    )
    reason: str = Field(description="Why it is disabled")
    former_until: float | None = Field(
        description="Time until which deliveries are also signed by the former secret [s since the epoch]"
    )
    created: float = Field(description="[s since the epoch]")

    @classmethod
    def of(cls, hook: Webhook) -> "WebhookAnswer":
        """Return a webhook as JSON."""
        return cls(
            id=hook.id,
            url=hook.url,
            events=list(hook.events),
            robots=list(hook.robots),
            maps=list(hook.maps),
            description=hook.description,
            state=hook.state,
            reason=hook.reason,
            former_until=hook.former_until or None,
            created=hook.created,
        )


class SecretAnswer(WebhookAnswer):
    """Webhook with a new secret."""

    secret: str = Field(description="Key of the signatures; it is returned only here")

    @classmethod
    def of(cls, hook: Webhook) -> "SecretAnswer":
        """Return a webhook with its secret as JSON."""
        return cls(**WebhookAnswer.of(hook).model_dump(), secret=shown_secret(hook.secret))


class DeliveryAnswer(ResponseBody):
    """Delivery that waits or was given up."""

    id: str = Field(description="`webhook-id` of its requests")
    event: str
    body: str = Field(description="JSON that is sent")
    state: DeliveryState
    attempts: int
    due: float | None = Field(description="Time of the next attempt [s since the epoch], as all times")
    reason: str = Field(description="Why the last attempt failed")
    created: float
    ended: float | None = Field(description="Time at which it was given up")

    @classmethod
    def of(cls, record: WebhookDelivery) -> "DeliveryAnswer":
        """Return a delivery as JSON."""
        return cls(
            id=record.id,
            event=record.event,
            body=record.body.decode(),
            state=record.state,
            attempts=record.attempts,
            due=record.due if record.state == "waiting" else None,
            reason=record.reason,
            created=record.created,
            ended=record.ended,
        )


class ReplayAnswer(ResponseBody):
    """Number of deliveries that are sent again."""

    replayed: int
