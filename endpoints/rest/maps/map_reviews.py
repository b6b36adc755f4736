"""Routes of map versions that wait for a review: list, show, approve and refuse them; and how they are proposed."""

from contextlib import ExitStack
from typing import Annotated

from fastapi import APIRouter, Path, Request
from msgspec.structs import replace
from starlette.concurrency import run_in_threadpool

from endpoints.audit.notes import note_details
from endpoints.rest.dependencies import Caller, Paged, Provided, may_read, owned_head, readable_head
from endpoints.rest.maps.review_schemas import Approval, MapReviewAnswer, RefusalOfVersion
from endpoints.rest.maps.schemas import MapSummary
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.strict_json import StrictRoute
from endpoints.services.services import Services
from endpoints.services.version_removal import follow_publication
from ppaas.clock import epoch
from ppaas.errors import InvalidParameter, NotFound, NotPermitted
from ppaas.maps.formats.difference import difference
from ppaas.maps.formats.map_files import open_grid
from storage.records import ConfirmedPlaces, MapChange, MapRecord, MapReview, Publication, User
from storage.staged_uploads import StagedUpload
from storage.versions import IMAGE, YAML

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


def check_may_propose(services: Services, user: User, head: MapRecord) -> None:
    """Raise ``NotFound`` if the user may not see a map, and ``NotPermitted`` if the user may not propose versions.

    May block.
    """
    if not may_read(services, user, head):
        raise NotFound("map", head.id)
    if user.role != "admin" and user.id != head.owner and user.id not in head.readers:
        raise NotPermitted(f"only the owner of map {head.id!r} and the readers named by the owner may propose versions")


async def propose(
    services: Services,
    user: User,
    upload: StagedUpload,
    publication: Publication,
    confirmed: ConfirmedPlaces | None = None,
) -> MapReviewAnswer:
    """Store an upload as a version that waits for a review.

    The owner, administrators and the readers that the owner has named may propose versions. ``confirmed`` are the
    places that a robot has found, if it is a robot's proposal.

    Raises
    ------
    NotFound
        The user may not see the map, or it does not exist.
    NotPermitted
        The user may not propose versions of it.
    Conflict, QuotaExceeded
        As ``MapStore.propose`` raises them.
    """
    map_id = publication.map
    head, change = await run_in_threadpool(_proposable, services, user, upload, map_id)
    proposal = Publication(map_id, user.id, epoch(), publication.message, head.owner, if_match=publication.if_match)
    change = replace(change, confirmed=confirmed)
    review = await services.usage.in_turn(head.owner, _propose, services, upload, proposal, head, change)
    return MapReviewAnswer.of(review, head.version)


def _proposable(services: Services, user: User, upload: StagedUpload, map_id: str) -> tuple[MapRecord, MapChange]:
    """Return a map of which the user may propose versions, and how an upload differs from its current version."""
    head = services.map_store.map_head(map_id)
    check_may_propose(services, user, head)
    return head, _change(services, upload, head)


def _propose(
    services: Services, upload: StagedUpload, proposal: Publication, head: MapRecord, change: MapChange
) -> MapReview:
    with services.usage.new_map(services, head.owner, head.id, upload):
        review = services.map_store.propose(upload, proposal, base=head.version, change=change)
    services.usage.stored.forget_map(head.owner, head.id)
    return review


def _change(services: Services, upload: StagedUpload, head: MapRecord) -> MapChange:
    """Return the difference from the current version; a version without a grid is compared with nothing."""
    if YAML not in upload.files or YAML not in head.present.files:
        return MapChange()
    with ExitStack() as stack:
        current = stack.enter_context(services.map_store.open_map(head.id, head.version, only=(YAML, IMAGE)))
        new = open_grid(bytes(upload.buffer(YAML)), upload.buffer(IMAGE))
        found = difference(open_grid(*current.grid()), new)
    counts = found.counts
    boxes = tuple((one.column, one.row, one.width, one.height) for one in found.rectangles)
    return MapChange(counts.occupied, counts.free, counts.known, counts.unknown, boxes)
