"""JSON schemas of merges of maps."""

from pydantic import Field

from endpoints.rest.maps.schemas import MapAnswer
from endpoints.rest.names import Name
from endpoints.rest.schemas import Description, RequestBody, Triple


class MapMerge(RequestBody):
    """Map to merge with, and the map that becomes the result."""

    with_: Name = Field(alias="with", description="Map that is moved into the frame of this one")
    into: Name = Field(description="Map that is published; may be one of the two")
    message: Description = Field("", description="Reason, stored with the version; by default, the names of both maps")


class MergedMapAnswer(MapAnswer):
    """Published map, and how the maps fit."""

    motion: Triple = Field(description="Frame of the other map in that of this one: x [m], y [m], yaw [rad]")
    places: int = Field(description="Number of places that both maps have and that agree")
    support: float = Field(description="Share of the scans of the other map near those of this one that fit, 0 to 1")
    confirmed: float = Field(description="Share of the points seen by both that agree, 0 to 1")
