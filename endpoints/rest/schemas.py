"""JSON schemas that the routes of the REST service share."""

import json
from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from endpoints.rest.names import Name
from endpoints.rest.strict_json import MAX_NESTING, is_deeper
from engine.rights.globs import GLOB, MAX_GLOBS, bare
from engine.specs.machine_settings import MOST_LABELS
from ppaas.plans.path_service import MAX_COORDINATE

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Pose = Annotated[
    list[Annotated[Number, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]],
    Field(min_length=2, max_length=3, description="x [m], y [m] and, optionally, yaw [rad] in the frame of the map"),
]
Triple = Annotated[list[float], Field(min_length=3, max_length=3, description="x [m], y [m], yaw [rad]")]

MAX_PARAMETERS = 1 << 16
"""Largest size of free-form parameters [characters of JSON]."""

MAX_CORES = 1024.0
Cores = Annotated[Number, Field(gt=0.0, le=MAX_CORES, description="CPUs of its container")]
Labels = Annotated[
    dict[Name, Name],
    Field(max_length=MOST_LABELS, description="Labels that its machine must have", examples=[{"zone": "hall-2"}]),
]

MAX_READERS = 256
MAX_DESCRIPTION = 1000
TopicGlob = Annotated[str, Field(pattern=f"^{GLOB}$"), AfterValidator(bare)]
TopicGlobs = Annotated[list[TopicGlob], Field(max_length=MAX_GLOBS)]
Reader = Annotated[Literal["*"] | Name, Field(union_mode="left_to_right")]
Description = Annotated[str, Field(max_length=MAX_DESCRIPTION)]


def triple(pose: Sequence[float]) -> tuple[float, float, float]:
    """Return x, y, yaw of a pose; the yaw is 0 if it is omitted."""
    x, y, *rest = pose
    return x, y, rest[0] if rest else 0.0


def plain_json(value: dict[str, Any]) -> dict[str, Any]:
    """Return an object unchanged; ``ValueError`` if it is too large, nested too deeply, or not valid JSON."""
    if is_deeper(value, MAX_NESTING):
        raise ValueError(f"may have at most {MAX_NESTING} objects and lists within each other")
    try:
        length = len(json.dumps(value, allow_nan=False))
    except ValueError as error:
        raise ValueError("numbers must be finite") from error
    if length > MAX_PARAMETERS:
        raise ValueError(f"must have at most {MAX_PARAMETERS} characters of JSON, not {length}")
    return value


FreeForm = Annotated[dict[str, Any], AfterValidator(plain_json)]
"""Free-form object: parameters or properties."""


class RequestBody(BaseModel):
    """Base of request bodies: unknown fields are rejected."""

    model_config = ConfigDict(extra="forbid")


class ResponseBody(BaseModel):
    """Base of response bodies, which may be built from the attributes of an object."""

    model_config = ConfigDict(from_attributes=True)


class Fault(BaseModel):
    """One error in a request."""

    where: list[str] = Field(
        description="Location: `body`, `query` or `path`, then the names of the fields down to the error"
    )
    what: str


class Problem(BaseModel):
    """Problem details (RFC 9457)."""

    type: str = Field(examples=["urn:ppaas:problem:goal-occupied"])
    title: str
    status: int
    detail: str = Field(description="Description of the error, with advice")
    code: int | None = Field(None, description="Error code of planning errors, as in Nav2's ComputePathToPose, 201–208")
    errors: list[Fault] | None = Field(None, description="All errors of an invalid request")
