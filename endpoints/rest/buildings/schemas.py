"""JSON schemas of buildings, their versions and their layouts."""

from typing import Annotated, Any, Self

import msgspec
from pydantic import BaseModel, Field

from endpoints.rest.schemas import MAX_READERS, Reader, RequestBody, ResponseBody, Triple
from ppaas.buildings.layout import BuildingLayout
from storage.buildings.records import BuildingRecord, BuildingVersion

Warnings = Annotated[list[str], Field(description="What is left out of its layout, or may be wrong")]
Spot = Annotated[list[float], Field(min_length=2, max_length=2, description="x, y [m] in the frame of the map")]


class BuildingVersionAnswer(BaseModel):
    """Version of a building."""

    version: int = Field(description="Rises by one from version to version")
    created: float = Field(description="Time at which it was made [s since the epoch]")
    author: str = Field(description="User who made it")
    message: str = Field(description="Reason given for the change")
    present: bool = Field(description="Whether it is the current version")

    @classmethod
    def of(cls, record: BuildingRecord, version: BuildingVersion, **more: Any) -> Self:
        """Return the answer for a version of a building, with more fields."""
        return cls(
            version=version.number,
            created=version.created,
            author=version.author,
            message=version.message,
            present=version == record.present,
            **more,
        )


class BuildingSummary(BuildingVersionAnswer):
    """Building without its settings."""

    id: str
    owner: str
    readers: list[str] = Field(description="Other users who may read it; `*` is everybody")
    floors: list[str] = Field(description="Names of its floors")
    maps: list[str] = Field(description="Ids of the maps of its floors, in the same order")
    elevations: list[float] = Field(description="Heights of its floors, in the same order [m]")

    @classmethod
    def summary(cls, record: BuildingRecord, version: BuildingVersion | None = None, **more: Any) -> Self:
        """Return the answer for a building, by default in its current version, with more fields."""
        shown = record.present if version is None else version
        return cls.of(
            record,
            shown,
            id=record.id,
            owner=record.user,
            readers=list(record.readers),
            floors=[floor.name for floor in shown.building.floors],
            maps=[floor.map for floor in shown.building.floors],
            elevations=[floor.elevation for floor in shown.building.floors],
            **more,
        )


class BuildingAnswer(BuildingSummary):
    """Building in one version."""

    building: dict[str, Any] = Field(
        description="Its `floors`, and the settings of its `lifts`, `doors` and `ways`, as they were put"
    )

    @classmethod
    def whole(cls, record: BuildingRecord, version: BuildingVersion | None = None, **more: Any) -> Self:
        """Return the answer for a building, by default in its current version, with more fields."""
        shown = record.present if version is None else version
        return cls.summary(record, shown, building=msgspec.to_builtins(shown.building), **more)


class PutBuildingAnswer(BuildingAnswer):
    """Building that was put."""

    warnings: Warnings


class BuildingChange(RequestBody):
    """Change of who may read a building."""

    readers: Annotated[list[Reader], Field(max_length=MAX_READERS)]


class FloorAnswer(ResponseBody):
    """Floor of a building."""

    name: str
    map: str
    elevation: float = Field(description="Height above the floor at 0 [m]")
    anchor: Triple = Field(description="Pose of the frame of its map in the frame of the building: x, y [m], yaw [rad]")


class DoorAnswer(ResponseBody):
    """Door on a floor."""

    floor: str
    door: str
    ends: list[Spot]
    lift: str = Field(description="Lift whose car is behind it; empty if there is none")


class LandingAnswer(ResponseBody):
    """Place where a lift stops."""

    floor: str
    door: str = Field(description="Door between floor and car")
    car: Triple = Field(description="Middle of the car, with the heading out of it")
    outline: list[Spot] = Field(description="Floor of the car")
    wait: Triple = Field(description="Where a robot waits, with the heading into the car")


class WayEndAnswer(ResponseBody):
    """End of stairs, a ramp or a bridge."""

    floor: str
    place: Triple = Field(description="Where robots enter it, with their heading")


class DockAnswer(ResponseBody):
    """Dock on a floor."""

    floor: str
    dock: str
    place: Triple = Field(description="Pose of a docked robot")
    dock_type: str
    charges: bool


class LayoutAnswer(BaseModel):
    """Places of a building on its floors, by the current zones of their maps; poses are in the frames of the maps."""

    version: int = Field(description="Version of the building")
    floors: list[FloorAnswer]
    lifts: dict[str, list[LandingAnswer]] = Field(description="Landings of each lift")
    ways: dict[str, list[WayEndAnswer]] = Field(description="Both ends of each way")
    doors: list[DoorAnswer]
    docks: list[DockAnswer]
    warnings: Warnings

    @classmethod
    def of(cls, version: int, layout: BuildingLayout) -> Self:
        """Return the answer for a layout."""
        given = msgspec.to_builtins(layout)
        landings = {
            lift: [landing | {"door": landing["door"]["door"]} for landing in places]
            for lift, places in given["landings"].items()
        }
        floors = [msgspec.structs.asdict(floor) for floor in layout.building.floors]
        return cls.model_validate(given | {"version": version, "floors": floors, "lifts": landings})


class CheckedBuilding(BaseModel):
    """Building that may be put, and how much of it was found on its maps."""

    floors: int = Field(description="Number of floors")
    lifts: int = Field(description="Number of lifts that stop on two floors or more")
    ways: int = Field(description="Number of ways with both ends")
    doors: int = Field(description="Number of doors, also of lifts")
    docks: int = Field(description="Number of docks")
    warnings: Warnings

    @classmethod
    def of(cls, layout: BuildingLayout) -> Self:
        """Return the answer for a layout."""
        return cls(
            floors=len(layout.building.floors),
            lifts=len(layout.landings),
            ways=len(layout.ways),
            doors=len(layout.doors),
            docks=len(layout.docks),
            warnings=list(layout.warnings),
        )
