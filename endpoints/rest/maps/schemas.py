"""The JSON of maps."""

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, Field

from endpoints.rest.names import Version
from endpoints.rest.schemas import MAX_READERS, Description, Reader, RequestBody, Triple
from storage.records import MapRecord


class MapSummary(BaseModel):
    """A map, without what only its files tell."""

    id: str
    owner: str
    version: str = Field(description="SHA-256 of its files")
    readers: list[str] = Field(description="Who else may see it and plan on it; `*` is everybody")
    created: float = Field(description="When this version was published [s since the epoch]")
    author: str = Field(description="Who published it")
    message: str = Field(description="Why")
    restored: bool = Field(description="Whether an older version was rolled back to")
    parts: list[str] = Field(description="Which files it has: `yaml` and `image`, a grid; `octomap`, an octree")
    description: str

    @classmethod
    def of(cls, record: MapRecord, **more: Any) -> Self:
        """Return what a record says, and what only the files tell."""
        present = record.present
        said: dict[str, Any] = {
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
        }
        return cls(**said, **more)


class RollBack(RequestBody):
    """Which version of a map shall be the present one again, and why."""

    version: Version
    message: Description = ""


class MapChange(RequestBody):
    """What is to be said of a map; what is left out stays, and null stands for none."""

    readers: Annotated[list[Reader], Field(max_length=MAX_READERS)] | None = None
    description: Description | None = None


class MapVersionAnswer(BaseModel):
    """A version of a map as it became the present one; what was rolled back to comes once more."""

    number: int = Field(description="Goes up from publication to publication, with gaps")
    version: str = Field(description="SHA-256 of its files")
    created: float = Field(description="When it was published [s since the epoch]")
    author: str = Field(description="Who published it")
    message: str = Field(description="Why")
    restored: bool = Field(description="Whether an older version was rolled back to")
    parts: list[str] = Field(description="Which files it has")
    present: bool = Field(description="Whether it is the one that robots drive and plan on now")


class MapAnswer(MapSummary):
    """A map; what is said of its grid is null where it has none."""

    resolution: float | None = Field(description="Edge of a cell [m]")
    width: int | None = Field(description="Cells along x")
    height: int | None = Field(description="Cells along y")
    origin: Triple | None = Field(description="Pose of the lower left corner of its grid: x [m], y [m], yaw [rad]")


class CellRectangle(BaseModel):
    """Cells of a grid; they may lie outside of it, where the grid before reached further."""

    column: int
    row: int = Field(description="From below")
    width: int
    height: int


OctomapFate = Literal["none", "same", "added", "removed", "changed"]


class MapDifference(BaseModel):
    """What became of a map from one version to another."""

    old: str = Field(description="SHA-256 of the files of the one")
    new: str = Field(description="SHA-256 of those of the other")
    changed: int = Field(description="Cells of the grid that are not what they were; beyond a grid all is unknown")
    rectangle: CellRectangle | None = Field(description="The least that has all of them, in cells of the new grid")
    corners: list[tuple[float, float]] | None = Field(
        description="Its corners, x and y [m] in the frame of the map, counterclockwise from (column, row)"
    )
    aligned: bool = Field(description="Whether cells of both lie on each other; else all of the new grid has changed")
    octomap: OctomapFate
