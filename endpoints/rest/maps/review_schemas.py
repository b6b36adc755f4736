"""JSON schemas of reviews of map versions."""

from typing import Annotated, Literal, Self

from pydantic import BaseModel, Field, StrictBool

from endpoints.rest.maps.schemas import CellRectangle
from endpoints.rest.schemas import Description, RequestBody
from storage.records import MapReview


class MapReviewAnswer(BaseModel):
    """Version of a map that waits for a review, or the result of the review."""

    number: int = Field(description="Ascending number, with gaps")
    version: str = Field(description="SHA-256 of its files, which can be downloaded while it waits")
    base: str = Field(description="Version that it was made from")
    created: float = Field(description="Time of the proposal [s since the epoch]")
    author: str = Field(description="User who proposed it")
    message: str = Field(description="Reason given for it")
    parts: list[str] = Field(description="Its files; empty once it was refused or approved")
    state: Literal["waiting", "approved", "refused"]
    outdated: bool = Field(description="Whether it waits and another version than `base` is the current one")
    occupied: int = Field(description="Number of cells that became occupied")
    free: int = Field(description="Number of cells that became free")
    known: int = Field(description="Number of cells that were unknown and are free or occupied now")
    unknown: int = Field(description="Number of cells that became unknown")
    rectangles: list[CellRectangle] = Field(description="Rectangles that cover all changed cells, at most 16")
    closed: float | None = Field(description="Time of the decision [s since the epoch]")
    closed_by: str = Field(description="User who approved or refused it")
    reason: str = Field(description="Reason given for the decision")

    @classmethod
    def of(cls, review: MapReview, current: str) -> Self:
        """Return the answer for a review, given the current version of its map."""
        change = review.change
        boxes = [CellRectangle(column=c, row=r, width=w, height=h) for c, r, w, h in change.rectangles]
        return cls(
            number=review.number, version=review.version, base=review.base, created=review.created,
            author=review.author, message=review.message, parts=sorted(review.files), state=review.state,
            outdated=review.waits and review.base != current, occupied=change.occupied, free=change.free,
            known=change.known, unknown=change.unknown, rectangles=boxes, closed=review.closed,
            closed_by=review.closed_by, reason=review.reason,
        )  # fmt: skip


class Approval(RequestBody):
    """Approval of a version that waits."""

    why: Description = ""
    force: StrictBool = Field(
        default=False, description="Approve it although its base is not the current version any more; `why` is required"
    )


class RefusalOfVersion(RequestBody):
    """Refusal of a version that waits."""

    why: Annotated[Description, Field(min_length=1)]
