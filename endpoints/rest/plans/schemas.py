"""The JSON of the Path Plan Database: what is sought, put in the place of another, and told of what plans share."""

from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, Field

from endpoints.rest.names import MapId, PluginName
from endpoints.rest.schemas import MAX_COORDINATE, Number, PlanSummary, _Answer, _Body, _plain
from ppaas.plans.stored import LARGEST_TOLERANCE

MOST_WAYPOINTS = 1 << 14
"""Poses that a request may bring; its body has an end too."""

MOST_FOUND = 100

Row = Annotated[
    list[Annotated[Number, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]], Field(min_length=7, max_length=7)
]


def _place(text: str) -> str:
    place_of(text)
    return text


def place_of(text: str) -> tuple[float, float]:
    """Return the x, y of a text such as ``2,-3.5``.

    Raises
    ------
    ValueError
        It is none; the text says what one is.
    """
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError as error:
        raise ValueError("a place is x,y in metres, such as 2,-3.5") from error
    if not max(abs(x), abs(y)) <= MAX_COORDINATE:
        raise ValueError(f"x and y are numbers up to {MAX_COORDINATE:g}")
    return x, y


Place = Annotated[str, AfterValidator(_place), Field(max_length=64, examples=["2,-3.5"])]


class PlanSearch(_Body):
    """Between which places paths are looked for."""

    map: MapId = Field(description="On whose present version they are")
    start: Place
    goal: Place
    tolerance: float = Field(0.25, ge=0.0, le=LARGEST_TOLERANCE, description="How far off an end may be [m]")
    planner: PluginName | None = None
    limit: int = Field(16, ge=1, le=MOST_FOUND)


class PlanPut(_Body):
    """A path that takes the place of a kept one, or is kept for the first time."""

    map: MapId
    planner: PluginName
    poses: Annotated[list[Row], Field(min_length=1, max_length=MOST_WAYPOINTS)] = Field(
        description="x, y, z [m], qx, qy, qz, qw a row, in the frame of the map"
    )
    cost: Annotated[Number, Field(ge=0.0)] = 0.0
    seconds: Annotated[Number, Field(ge=0.0, description="Time the planner took [s]")] = 0.0
    parameters: Annotated[dict[str, Any], AfterValidator(_plain)] = Field({}, description="The planner's")


class PlanChange(PlanPut):
    """What is changed of a kept path; what is left out stays."""

    map: MapId | None = None  # type: ignore[assignment]
    planner: PluginName | None = None  # type: ignore[assignment]
    poses: Annotated[list[Row], Field(min_length=1, max_length=MOST_WAYPOINTS)] | None = None  # type: ignore[assignment]


class FoundPlans(_Answer):
    """Paths that were kept between two places, the shortest first."""

    items: list[PlanSummary]
    next: None = None


class PartAnswer(_Answer):
    """A stretch that a path shares."""

    entry: str = Field(description="Its id in the database: equal stretches have the same")
    first: int = Field(description="Its first waypoint in the path")
    count: int = Field(description="How many it has")
    plans: int = Field(description="How often paths refer to it")


class Parts(BaseModel):
    """The stretches of a path that are entries of their own, in order."""

    items: list[PartAnswer]
    next: None = None


class StatisticsAnswer(_Answer):
    """What the paths on a map take."""

    plans: int
    waypoints: int = Field(description="Of all paths")
    kept: int = Field(description="Waypoints that are kept for them")
    entries: int = Field(description="Stretches that paths share")
    bytes: int = Field(description="What paths and entries take, without indexes")
