"""Routes of map versions that wait for a review: list, show, approve and refuse them."""

from typing import Annotated

from fastapi import APIRouter, Path, Request
from starlette.concurrency import run_in_threadpool

from endpoints.audit.requests import note_details
from endpoints.resources.services import Services
from endpoints.resources.version_removal import follow_publication
from endpoints.rest.dependencies import Caller, Paged, Provided, owned_head, readable_head
from endpoints.rest.maps.schemas import Approval, MapReviewAnswer, MapSummary, RefusalOfVersion
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.strict_json import StrictRoute
from ppaas.clock import epoch
from ppaas.errors import InvalidParameter, NotFound
from storage.records import MapRecord, MapReview, Publication

router = APIRouter(prefix="/maps/{map_id}/reviews", tags=["maps"], route_class=StrictRoute)

MAX_NUMBER = (1 << 53) - 1
"""Largest number that JSON programs read exactly."""

ReviewNumber = Annotated[int, Path(ge=1, le=MAX_NUMBER, description="Number of the review")]


@router.get("", response_model=Page[MapReviewAnswer], responses=KNOWN | problems(404))
async def list_reviews(map_id: MapId, services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the versions of a map that wait for a review, and the last ones that were reviewed, newest first."""
    await readable_head(services, user, map_id)
    head, found = await run_in_threadpool(_reviews, services, map_id)
    before = paging.key(int, MAX_NUMBER + 1)
    listed = [MapReviewAnswer.of(one, head.version) for one in found if one.number < before]
    return paging.page(listed[: paging.fetch_limit], lambda one: one.number)


@router.get("/{number}", response_model=MapReviewAnswer, responses=KNOWN | problems(404))
async def show_review(map_id: MapId, number: ReviewNumber, services: Provided, user: Caller) -> MapReviewAnswer:
    """Show a version that waits for a review, or the result of the review."""
    await readable_head(services, user, map_id)
    head, found = await run_in_threadpool(_reviews, services, map_id)
    for review in found:
        if review.number == number:
            return MapReviewAnswer.of(review, head.version)
    raise NotFound(f"review of map {map_id!r}:", str(number), [str(one.number) for one in found if one.waits])


@router.post("/{number}/approve", response_model=MapSummary, responses=KNOWN | BODY | problems(403, 404, 409))
async def approve_review(
    map_id: MapId, number: ReviewNumber, approval: Approval, *, request: Request, services: Provided, user: Caller
) -> MapSummary:
    """Make a version that waits the current one; robots that drive on the map go on with it."""
    if approval.force and not approval.why.strip():
        raise InvalidParameter("why: say why the changes since version `base` may be undone")
    head = await owned_head(services, user, map_id)
    decision = Publication(map_id, user.id, epoch(), approval.why, head.owner)
    try:
        record = await services.usage.in_turn(
            head.owner, _approve, services, head, number, decision, force=approval.force
        )
    finally:
        services.map_cache.forget(map_id)
    note_details(request.scope, version=record.version, before=head.version, author=record.present.author)
    await follow_publication(services, record)
    return MapSummary.of(record)


@router.post("/{number}/refuse", response_model=MapReviewAnswer, responses=KNOWN | BODY | problems(403, 404, 409))
async def refuse_review(
    map_id: MapId,
    number: ReviewNumber,
    refusal: RefusalOfVersion,
    *,
    request: Request,
    services: Provided,
    user: Caller,
) -> MapReviewAnswer:
    """Refuse a version that waits; its files are removed."""
    head = await owned_head(services, user, map_id)
    decision = Publication(map_id, user.id, epoch(), refusal.why, head.owner)
    review = await services.usage.in_turn(head.owner, _refuse, services, head, number, decision)
    note_details(request.scope, version=review.version, author=review.author)
    return MapReviewAnswer.of(review, head.version)


def _approve(services: Services, head: MapRecord, number: int, decision: Publication, *, force: bool) -> MapRecord:
    try:
        return services.map_store.approve(number, decision, force=force)
    finally:
        services.usage.stored.forget_map(head.owner, head.id)


def _refuse(services: Services, head: MapRecord, number: int, decision: Publication) -> MapReview:
    try:
        return services.map_store.refuse(number, decision)
    finally:
        services.usage.stored.forget_map(head.owner, head.id)


def _reviews(services: Services, map_id: str) -> tuple[MapRecord, list[MapReview]]:
    return services.map_store.map_head(map_id), services.map_store.reviews(map_id)
