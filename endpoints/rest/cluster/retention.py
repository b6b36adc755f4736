"""Routes of retention, for administrators: for how long data are kept, and what has expired."""

from typing import Annotated

from fastapi import APIRouter, Request
from pydantic import Field, StrictBool

from endpoints.audit.requests import note_details
from endpoints.resources.services import Services
from endpoints.rest.dependencies import Admin, Provided
from endpoints.rest.openapi import ADMIN, BODY
from endpoints.rest.schemas import RequestBody, ResponseBody
from endpoints.rest.strict_json import StrictRoute
from endpoints.retention.calls import RetentionCalls
from ppaas.errors import Unavailable

router = APIRouter(prefix="/retention", tags=["retention"], route_class=StrictRoute)


class RetentionAnswer(ResponseBody):
    """Retention of a kind of data."""

    kind: str
    text: str = Field(description="What is removed, and how its age is measured")
    days: float | None = Field(description="Age beyond which it is removed; null if it is kept however old it is")
    last_run: float | None = Field(description="Time at which this master removed it last [s since the epoch]")
    removed: int | None = Field(description="Number that was removed then; null if that failed")
    gigabytes: float | None = Field(description="Size beyond which the oldest are removed [GB]; null without a limit")


class ExpireRequest(RequestBody):
    """Whether to remove what has expired."""

    dry_run: Annotated[StrictBool, Field(description="Only count what has expired")] = False


class ExpiredAnswer(ResponseBody):
    """What has expired of a kind of data."""

    kind: str
    before: float = Field(description="What is older has expired [s since the epoch]; 0 if only the size is limited")
    expired: int = Field(description="Number that has expired, and was removed unless `dry_run`")
    fault: str = Field(description="Why it could not be removed; empty if it could")


@router.get("", response_model=list[RetentionAnswer], responses=ADMIN)
async def show_retention(services: Provided, _admin: Admin) -> list[RetentionAnswer]:
    """Show for how long each kind of data is kept."""
    return [RetentionAnswer.model_validate(view) for view in await _calls(services).views()]


@router.post("", response_model=list[ExpiredAnswer], responses=ADMIN | BODY)
async def expire_data(
    wanted: ExpireRequest, request: Request, services: Provided, _admin: Admin
) -> list[ExpiredAnswer]:
    """Remove what has expired now, instead of once a day; or only count it."""
    note_details(request.scope, dry_run=wanted.dry_run)
    return [ExpiredAnswer.model_validate(found) for found in await _calls(services).expire(wanted.dry_run)]


def _calls(services: Services) -> RetentionCalls:
    if services.retention is None:
        raise Unavailable("no master keeps data for this endpoint")
    return services.retention
