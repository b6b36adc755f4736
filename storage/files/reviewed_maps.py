"""Map store with versions that wait for a review.

Reviews are part of each entry of a map's log. So a proposal, an approval and a refusal are one entry each, and of
concurrent ones each sees those before it. Entries have a bounded size: a map has up to `MAX_WAITING` reviews that wait
and `MAX_CLOSED` closed ones, whose files are not listed any more.
"""

from msgspec.structs import replace

from ppaas.errors import Conflict, NotFound, QuotaExceeded
from storage.files.log_entries import LatestEntry, changed, files_of, files_path, followed
from storage.files.map_log import LoggedMapStore
from storage.names import check_name
from storage.records import MapRecord, MapReview, MapVersionRecord, ProposedChange, Publication, ReviewState
from storage.staged_uploads import StagedUpload
from storage.versions import ZONES, check_may_follow, check_publication, map_version

MAX_WAITING = 16
"""Largest number of versions of a map that wait."""

MAX_WAITING_BYTES = 1 << 30
"""Largest size of their files together [bytes]."""

MAX_CLOSED = 16
"""Number of closed reviews of a map that are listed."""

Reviews = tuple[MapReview, ...]


class ReviewedMapStore(LoggedMapStore):
    """A ``MapStore`` on a disk."""

    def propose(
        self, upload: StagedUpload, publication: Publication, *, base: str, change: ProposedChange
    ) -> MapReview:
        """Store the uploaded files as a version that waits for a review; the current version stays."""
        check_publication(publication)
        check_name("version", base)
        placed = set()
        while True:
            latest = self._latest(publication.map)
            head = latest.head(publication.map)
            check_may_follow(head, publication)
            review = _proposal(latest, publication, upload, base, change)
            known = _same(latest.reviews, review.version)
            if known is not None:
                return known
            _check_proposal(latest, head, review)
            if latest.era not in placed:
                self._place(upload, files_path(publication.map, latest.era))
                placed.add(latest.era)
            if self._append(latest, head, latest.era, reviews=(*latest.reviews, review)):
                self._replace_moved(upload, files_path(publication.map, latest.era))
                return review

    def reviews(self, map_id: str) -> list[MapReview]:
        """Return the reviews of a map, newest first: all that wait, and the last that were closed."""
        check_name("map", map_id)
        latest = self._latest(map_id)
        latest.head(map_id)
        return sorted(latest.reviews, key=lambda review: -review.number)

    def approve(self, number: int, publication: Publication, *, force: bool = False) -> MapRecord:
        """Make a version that waits the current one, atomically; return the map's head."""
        check_publication(publication)
        while True:
            latest, head, review = self._under_review(number, publication)
            if not _is_open(review, "approved"):
                return head
            if review.base != head.version and not force:
                raise _outdated(review, head)
            record = changed(_with_version(head, latest, review, publication), publication.readers, None)
            closed = _closed(latest, review, "approved", publication)
            if self._append(latest, record, latest.era, reviews=followed(replace(latest, reviews=closed), record)):
                return record

    def refuse(self, number: int, publication: Publication) -> MapReview:
        """Close a review without publishing, and remove the files that no version has; return it."""
        check_publication(publication)
        while True:
            latest, head, review = self._under_review(number, publication)
            if not _is_open(review, "refused"):
                return review
            reviews = _closed(latest, review, "refused", publication)
            if self._append(latest, head, latest.era, reviews=reviews):
                names = {file.sha256 for file in review.files.values()}
                self._sweep_of(publication.map).delete(names, self._latest(publication.map))
                return next(one for one in reviews if one.number == number)

    def _under_review(self, number: int, decision: Publication) -> tuple[LatestEntry, MapRecord, MapReview]:
        """Return the latest entry of a map, its head, and a review that the author of a decision may close."""
        latest = self._latest(decision.map)
        head = latest.head(decision.map)
        check_may_follow(head, decision)
        return latest, head, _review(latest, decision.map, number)


def _proposal(
    latest: LatestEntry, publication: Publication, upload: StagedUpload, base: str, change: ProposedChange
) -> MapReview:
    files = files_of(latest, publication.map, upload)
    return MapReview(
        latest.number + 1, map_version(files), base, publication.created, publication.author, publication.message,
        files, change, keeps_zones=ZONES in upload.keeps,
    )  # fmt: skip


def _check_proposal(latest: LatestEntry, head: MapRecord, review: MapReview) -> None:
    """Raise ``Conflict`` if a proposed version is the current one, ``QuotaExceeded`` if too much would wait."""
    if review.version == head.version:
        raise Conflict(f"the files are those of the current version of map {head.id!r}: there is nothing to review")
    waiting = [one for one in latest.reviews if one.waits]
    size = sum(file.size for one in (*waiting, review) for file in one.files.values())
    if len(waiting) >= MAX_WAITING or size > MAX_WAITING_BYTES:
        raise QuotaExceeded(
            f"{len(waiting)} versions of map {head.id!r} wait for their review, at most {MAX_WAITING} with "
            f"{MAX_WAITING_BYTES >> 20} MiB may: approve or refuse some first"
        )


def _same(reviews: Reviews, version: str) -> MapReview | None:
    return next((one for one in reviews if one.waits and one.version == version), None)


def _review(latest: LatestEntry, map_id: str, number: int) -> MapReview:
    for review in latest.reviews:
        if review.number == number:
            return review
    raise NotFound(f"review of map {map_id!r}:", str(number), [str(one.number) for one in latest.reviews if one.waits])


def _is_open(review: MapReview, wanted: ReviewState) -> bool:
    """Return whether a review waits; ``Conflict`` if it was closed in another way than wanted."""
    if not review.waits and review.state != wanted:
        raise Conflict(f"review {review.number} was {review.state} by {review.closed_by!r} already: propose it again")
    return review.waits


def _outdated(review: MapReview, head: MapRecord) -> Conflict:
    return Conflict(
        f"review {review.number} was made from version {review.base}, but map {head.id!r} is at version "
        f"{head.version}, whose changes it would undo: propose it again from the current version, or approve it with "
        "force and say why"
    )


def _with_version(head: MapRecord, latest: LatestEntry, review: MapReview, publication: Publication) -> MapRecord:
    if head.version == review.version:  # published in another way meanwhile
        return head
    present = MapVersionRecord(
        latest.number + 1, review.version, publication.created, review.author, review.message, files=review.files
    )
    return replace(head, present=present)


def _closed(latest: LatestEntry, review: MapReview, state: ReviewState, publication: Publication) -> Reviews:
    """Return the reviews after one was closed, without the oldest closed ones beyond `MAX_CLOSED`."""
    closed = replace(
        review, files={}, state=state, closed=publication.created, closed_by=publication.author,
        reason=publication.message,
    )  # fmt: skip
    reviews = [closed if one is review else one for one in latest.reviews]
    kept = sorted((one for one in reviews if not one.waits), key=lambda one: one.closed or 0.0)[-MAX_CLOSED:]
    return tuple(one for one in reviews if one.waits or one in kept)
