"""JSON schema of audit events."""

from typing import Any

from pydantic import Field

from endpoints.audit.event import Outcome
from endpoints.rest.schemas import ResponseBody


class AuditAnswer(ResponseBody):
    """Event of the audit log."""

    number: int = Field(description="Number of the event; later events have larger numbers")
    time: float = Field(description="Seconds since the epoch")
    user: str | None = Field(description="User who did it; null if unknown")
    token: str | None = Field(description="First characters of the id of the user's token")
    address: str = Field(description="Address of the client; empty for the host of the cloud")
    action: str = Field(
        description="Id of the operation, as `remove_map`; or `connect`, `disconnect`, `start_cloud`, `stop_cloud`, "
        "`make_ticket`, `propose_change` by a robot that maps for life, `lose_events`",
        examples=["remove_map"],
    )
    object: str | None = Field(description="Object of the action", examples=["maps/office"])
    outcome: Outcome
    status: int | None = Field(description="HTTP status")
    reason: str | None = Field(description="Slug of the problem", examples=["not-permitted"])
    details: dict[str, Any] = Field(description="Changes that were made, without secrets")
    repeats: int = Field(description="Number of similar events of the last minute that are not listed")
