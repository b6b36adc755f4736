"""JSON schemas that all routes of the REST service share: for checks of requests and descriptions of responses."""

import json
from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from endpoints.rest.names import Name
from engine.service.path_requests import MAX_COORDINATE
from engine.specs.machine_settings import MOST_LABELS

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Pose = Annotated[
    list[Annotated[Number, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]],
    Field(min_length=2, max_length=3, description="x [m], y [m] and, if it matters, yaw [rad] in the frame of the map"),
]
Triple = Annotated[list[float], Field(min_length=3, max_length=3, description="x [m], y [m], yaw [rad]")]

MAX_PARAMETERS = 1 << 16
MAX_CORES = 1024.0
Cores = Annotated[Number, Field(gt=0.0, le=MAX_CORES, description="Size of its container")]
Labels = Annotated[
    dict[Name, Name],
    Field(max_length=MOST_LABELS, description="Those that its machine must have", examples=[{"zone": "hall-2"}]),
]

MAX_READERS = 256
MAX_DESCRIPTION = 1000
Reader = Annotated[Literal["*"] | Name, Field(union_mode="left_to_right")]
Description = Annotated[str, Field(max_length=MAX_DESCRIPTION)]


def triple(pose: Sequence[float]) -> tuple[float, float, float]:
    """Return x, y, yaw of a pose that may come without its yaw."""
    x, y, *rest = pose
    return x, y, rest[0] if rest else 0.0


def plain_json(value: dict[str, Any]) -> dict[str, Any]:
    """Return an object as it is; ``ValueError`` if it is too large, or not plain JSON."""
    try:
        length = len(json.dumps(value, allow_nan=False))
    except (ValueError, RecursionError) as error:
        raise ValueError("what is in it must be finite and not deeply nested") from error
    if length > MAX_PARAMETERS:
        raise ValueError(f"it may have {MAX_PARAMETERS} characters of JSON, not {length}")
    return value


class RequestBody(BaseModel):
    """Base of what is taken: a member that is not described is refused."""

    model_config = ConfigDict(extra="forbid")


class ResponseBody(BaseModel):
    """Base of what is given: it may be read from the attributes of an object."""

    model_config = ConfigDict(from_attributes=True)


class Fault(BaseModel):
    """One of the things that are wrong with a request."""

    where: list[str] = Field(description="The way to it: `body`, `query` or `path`, and the names on the way")
    what: str


class Problem(BaseModel):
    """What went wrong (RFC 9457)."""

    type: str = Field(examples=["urn:ppaas:problem:goal-occupied"])
    title: str
    status: int
    detail: str = Field(description="What is wrong, and what to do about it")
    code: int | None = Field(None, description="Of planning errors: that of Nav2's ComputePathToPose, 201–208")
    errors: list[Fault] | None = Field(None, description="Of invalid requests: all that is wrong")
