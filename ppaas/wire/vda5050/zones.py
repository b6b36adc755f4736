"""Messages of a master control of 3.0: sets of zones, and responses to requests of an AGV."""

from typing import Annotated, Literal

from msgspec import Meta

from ppaas.wire.vda5050.fields import BlockingType, Fields, Point
from ppaas.wire.vda5050.orders import ActionParameter

ZoneType = Literal[
    "BLOCKED",
    "LINE_GUIDED",
    "RELEASE",
    "COORDINATED_REPLANNING",
    "SPEED_LIMIT",
    "ACTION",
    "PRIORITY",
    "PENALTY",
    "DIRECTED",
    "BIDIRECTED",
]


class ZoneAction(Fields):
    """Action of a zone."""

    action_type: str
    blocking_type: BlockingType
    action_descriptor: str | None = None
    action_parameters: list[ActionParameter] | None = None
    retriable: bool | None = None


class Zone(Fields):
    """Zone: a polygon [m], and what its type needs: a speed [m/s], a factor from 0 to 1, a direction [rad]."""

    zone_id: str
    zone_type: ZoneType
    vertices: Annotated[list[Point], Meta(min_length=3)]
    zone_descriptor: str | None = None
    release_loss_behavior: Literal["STOP", "CONTINUE", "EVACUATE"] | None = None
    maximum_speed: float | None = None
    entry_actions: list[ZoneAction] | None = None
    during_actions: list[ZoneAction] | None = None
    exit_actions: list[ZoneAction] | None = None
    priority_factor: float | None = None
    penalty_factor: float | None = None
    direction: float | None = None
    directed_limitation: Literal["SOFT", "RESTRICTED", "STRICT"] | None = None
    bidirected_limitation: Literal["SOFT", "RESTRICTED"] | None = None


class Zones(Fields):
    """Zones of a map."""

    map_id: str
    zone_set_id: str
    zones: list[Zone]
    zone_set_descriptor: str | None = None


class ZoneSet(Fields):
    """Message with a set of zones."""

    zone_set: Zones


class Response(Fields):
    """Response to a request."""

    request_id: str
    grant_type: Literal["GRANTED", "QUEUED", "REVOKED", "REJECTED"]
    lease_expiry: str | None = None


class Responses(Fields):
    """Message with responses to requests."""

    responses: list[Response]
