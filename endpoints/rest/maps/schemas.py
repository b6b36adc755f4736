"""JSON schemas of maps, and of the reviews of their versions."""

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, Field, StrictBool

from endpoints.rest.names import Version
from endpoints.rest.schemas import MAX_READERS, Description, Reader, RequestBody, Triple
from storage.records import MapRecord, MapReview


class MapSummary(BaseModel):
    """Map without the properties of its grid."""

    id: str
    owner: str
    version: str = Field(description="SHA-256 of its files")
    readers: list[str] = Field(description="Other users who may read it and plan on it; `*` is everybody")
    created: float = Field(description="Time of publication of this version [s since the epoch]")
    author: str = Field(description="User who published it")
    message: str = Field(description="Reason given for the publication")
    restored: bool = Field(description="Whether it was restored by a roll back")
    parts: list[str] = Field(
        description="Its files: `yaml` and `image` for a grid, `octomap` for an octree, `posegraph`, `zones`"
    )
    description: str
    traffic: bool = Field(description="Whether all robots on it take part in its traffic")

    @classmethod
    def of(cls, record: MapRecord, **more: Any) -> Self:
        """Return the answer for a record, with more fields from its files."""
        present = record.present
        fields: dict[str, Any] = {
            "id": record.id,
            "owner": record.owner,
            "version": present.version,
            "readers": list(record.readers),
            "created": present.created,
            "author": present.author,
            "message": present.message,
            "restored": present.restored,
            "parts": sorted(present.files),
            "description": record.description,
            "traffic": record.traffic,
        }
        return cls(**fields, **more)


class RollBack(RequestBody):
    """Version of a map to restore, and the reason."""

    version: Version
    message: Description = ""


class MapChange(RequestBody):
    """Changes of a map; omitted fields stay unchanged, null clears a field."""

    readers: Annotated[list[Reader], Field(max_length=MAX_READERS)] | None = None
    description: Description | None = None
    traffic: StrictBool | None = None


class MapVersionAnswer(BaseModel):
    """Publication or roll back that made a version the current one; a restored version is listed again."""

    number: int = Field(description="Ascending number of the publication, with gaps")
    version: str = Field(description="SHA-256 of its files")
    created: float = Field(description="Time of publication [s since the epoch]")
    author: str = Field(description="User who published it")
    message: str = Field(description="Reason given for the publication")
    restored: bool = Field(description="Whether it was restored by a roll back")
    parts: list[str] = Field(description="Its files")
    present: bool = Field(description="Whether it is the current version, used for planning and by robots that connect")


class MapAnswer(MapSummary):
    """Map with the properties of its grid, which are null if it has no grid."""

    resolution: float | None = Field(description="Size of a cell [m]")
    width: int | None = Field(description="Number of cells along x")
    height: int | None = Field(description="Number of cells along y")
    origin: Triple | None = Field(description="Pose of the lower left corner of its grid: x [m], y [m], yaw [rad]")
    georeference: Triple | None = Field(
        description="Where the map's origin is: latitude and longitude [°], and the yaw of its x axis from east [rad]"
    )


Warnings = Annotated[
    list[str],
    Field(description="What was mended in the zones that were sent, and what may be wrong in them or in the YAML"),
]


class PublishedMap(MapAnswer):
    """Map that was published."""

    warnings: Warnings = []


class PublishedZones(MapSummary):
    """Map whose zones were published."""

    warnings: Warnings = []


class CheckedZonesAnswer(BaseModel):
    """Zones that may be published."""

    zones: int = Field(description="Number of zones")
    warnings: Warnings


class CellRectangle(BaseModel):
    """Rectangle of cells of a grid; it may reach beyond the grid if the older grid did."""

    column: int
    row: int = Field(description="Counted from the bottom")
    width: int
    height: int


PartFate = Literal["none", "same", "added", "removed", "changed"]


class MapDifference(BaseModel):
    """Differences between two versions of a map."""

    old: str = Field(description="SHA-256 of the files of the older version")
    new: str = Field(description="SHA-256 of the files of the newer version")
    changed: int = Field(description="Number of changed cells; cells outside a grid count as unknown")
    rectangle: CellRectangle | None = Field(
        description="Smallest rectangle of all changed cells, in cells of the newer grid"
    )
    corners: list[tuple[float, float]] | None = Field(
        description="Corners of the rectangle, x and y [m] in the frame of the map, counterclockwise from (column, row)"
    )
    aligned: bool = Field(
        description="Whether the cells of both grids are aligned; if not, all cells of the newer one count as changed"
    )
    octomap: PartFate
    zones: PartFate


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
