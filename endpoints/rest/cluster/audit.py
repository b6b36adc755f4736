"""Route of the audit log, for administrators."""

from typing import Annotated, Any, ClassVar

import msgspec
from fastapi import APIRouter, Depends, Query, Request
from pydantic import Field
from starlette.concurrency import run_in_threadpool

from endpoints.audit.event import AuditQuery, Outcome
from endpoints.rest.dependencies import Admin, Provided
from endpoints.rest.openapi import ADMIN
from endpoints.rest.paging import DEFAULT_LIMIT, Cursor, Limit, Page, Paging
from endpoints.rest.schemas import ResponseBody

router = APIRouter(prefix="/audit", tags=["audit"])

_Text = Annotated[str | None, Query(max_length=128)]


class AuditAnswer(ResponseBody):
    """Event of the audit log."""

    number: int = Field(description="Number of the event; later events have larger numbers")
    time: float = Field(description="Seconds since the epoch")
    user: str | None = Field(description="User who did it; null if unknown")
    token: str | None = Field(description="First characters of the id of the user's token")
    address: str = Field(description="Address of the client; empty for the host of the cloud")
    action: str = Field(
        description="Id of the operation, as `remove_map`; or `connect`, `disconnect`, `start_cloud`, `stop_cloud`, "
        "`make_ticket`, `hand_over`, `propose_change` by a robot that maps for life, `lose_events`, "
        "`disable_webhook` by a target that is gone, `expire_data`, `reload_settings`",
        examples=["remove_map"],
    )
    object: str | None = Field(description="Object of the action", examples=["maps/office"])
    outcome: Outcome
    status: int | None = Field(description="HTTP status")
    reason: str | None = Field(description="Slug of the problem", examples=["not-permitted"])
    details: dict[str, Any] = Field(description="Changes that were made, without secrets")
    repeats: int = Field(description="Number of similar events of the last minute that are not listed")


class AuditPaging(Paging):
    """Parameters of a page of events: as for every list, and the events that are sought.

    Parameters
    ----------
    request, limit, cursor
        As in every list.
    after : float, optional
        Time [s since the epoch]; only events at or after it.
    user, action : str, optional
        Only events of this user, and of this action.
    outcome : {"ok", "refused", "failed"}, optional
        Only events with this outcome.
    object_name : str, optional
        Only events of this object and its parts.
    """

    filters: ClassVar[frozenset[str]] = frozenset({"after", "user", "action", "outcome", "object"})

    def __init__(  # noqa: PLR0917  # FastAPI passes them by name
        self,
        request: Request,
        limit: Limit = DEFAULT_LIMIT,
        cursor: Cursor = None,
        after: Annotated[
            float | None,
            Query(allow_inf_nan=False, description="Only events at or after this time [s since the epoch]"),
        ] = None,
        user: _Text = None,
        action: _Text = None,
        outcome: Outcome | None = None,
        object_name: Annotated[
            str | None,
            Query(
                alias="object",
                max_length=256,
                description="Only events of this object and its parts, as `robots/tb1`",
            ),
        ] = None,
    ) -> None:
        super().__init__(request, limit, cursor)
        self.query = AuditQuery(after, user, action, outcome, object_name)


@router.get("", response_model=Page[AuditAnswer], responses=ADMIN)
async def list_events(
    services: Provided, _admin: Admin, paging: Annotated[AuditPaging, Depends()]
) -> dict[str, object]:
    """List the events of the audit log, newest first: who did what, from where, and with what outcome."""
    before = paging.key(int, None)
    found = await run_in_threadpool(services.audit.read, paging.query, before=before, limit=paging.fetch_limit)
    return paging.page([AuditAnswer(**msgspec.structs.asdict(event)) for event in found], lambda event: event.number)
