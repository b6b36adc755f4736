"""Proposals of map versions: uploads that wait for a review, by a request or by the watch of robots' maps.

The watch runs in the process of the master, which has no web framework, so this module needs none.
"""

from contextlib import ExitStack

from msgspec.structs import replace
from starlette.concurrency import run_in_threadpool

from endpoints.resources.services import Services
from endpoints.sharing.shared_robots import may_read
from ppaas.clock import epoch
from ppaas.errors import NotFound, NotPermitted
from ppaas.maps.formats.difference import difference
from ppaas.maps.formats.map_files import open_grid
from storage.records import ConfirmedPlaces, MapRecord, MapReview, ProposedChange, Publication, User
from storage.staged_uploads import StagedUpload
from storage.versions import IMAGE, YAML


def check_may_propose(services: Services, user: User, head: MapRecord) -> None:
    """Raise ``NotFound`` if the user may not see a map, and ``NotPermitted`` if the user may not propose versions.

    May block.
    """
    if not may_read(services.store, user, head):
        raise NotFound("map", head.id)
    if user.role != "admin" and user.id != head.owner and user.id not in head.readers:
        raise NotPermitted(f"only the owner of map {head.id!r} and the readers named by the owner may propose versions")


async def propose(
    services: Services,
    user: User,
    upload: StagedUpload,
    publication: Publication,
    confirmed: ConfirmedPlaces | None = None,
) -> MapReview:
    """Store an upload as a version that waits for a review; return the review.

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
    return await services.usage.in_turn(head.owner, _propose, services, upload, proposal, head, change)


def _proposable(services: Services, user: User, upload: StagedUpload, map_id: str) -> tuple[MapRecord, ProposedChange]:
    """Return a map of which the user may propose versions, and how an upload differs from its current version."""
    head = services.map_store.map_head(map_id)
    check_may_propose(services, user, head)
    return head, _change(services, upload, head)


def _propose(
    services: Services, upload: StagedUpload, proposal: Publication, head: MapRecord, change: ProposedChange
) -> MapReview:
    with services.usage.new_map(services, head.owner, head.id, upload):
        review = services.map_store.propose(upload, proposal, base=head.version, change=change)
    services.usage.stored.forget_map(head.owner, head.id)
    return review


def _change(services: Services, upload: StagedUpload, head: MapRecord) -> ProposedChange:
    """Return the difference from the current version; a version without a grid is compared with nothing."""
    if YAML not in upload.files or YAML not in head.present.files:
        return ProposedChange()
    with ExitStack() as stack:
        current = stack.enter_context(services.map_store.open_map(head.id, head.version, only=(YAML, IMAGE)))
        new = open_grid(bytes(upload.buffer(YAML)), upload.buffer(IMAGE))
        found = difference(open_grid(*current.grid()), new)
    counts = found.counts
    boxes = tuple((one.column, one.row, one.width, one.height) for one in found.rectangles)
    return ProposedChange(counts.occupied, counts.free, counts.known, counts.unknown, boxes)
