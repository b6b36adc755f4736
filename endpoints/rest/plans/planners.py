"""Planners that robot files and requests may name."""

from typing import Any, Literal

from fastapi import APIRouter
from pydantic import BaseModel, Field

from endpoints.rest.dependencies import Caller, Provided
from endpoints.rest.names import PlannerName
from endpoints.rest.openapi import KNOWN, problems
from ppaas.errors import NotFound

router = APIRouter(prefix="/planners", tags=["planners"])


class PlannerAnswer(BaseModel):
    """A planner."""

    name: str
    aliases: list[str] = Field(description="Names that ROS has for it, or for one of its kind")
    purpose: str = Field(description="When to choose it")
    parameters: dict[str, Any] = Field(description="What a robot file may set, and what it is by default")
    optimal: Literal["always", "uniform", "never"] = Field(
        description="Whether its paths are the cheapest: on any costs, where all free cells cost the same, or perhaps"
    )
    weighted: bool = Field(description="Whether it heeds what free cells cost")
    any_angle: bool = Field(description="Whether paths may run in any direction")
    kinematic: bool = Field(description="Whether a robot that cannot turn on the spot can drive them")
    indexed: bool = Field(description="Whether it prepares a map, once, for many queries")
    incremental: bool = Field(description="Whether it replans with less work after a change of the map")
    dimensions: int = Field(description="Of the maps that it plans on")


class PlannerPage(BaseModel):
    """All planners: they are few, and on one page."""

    items: list[PlannerAnswer]
    next: None = None


@router.get("", response_model=PlannerPage, responses=KNOWN)
async def list_planners(services: Provided, _user: Caller) -> dict[str, Any]:
    """List the planners that robot files and requests for paths may name."""
    return {"items": await services.planners.all()}


@router.get("/{planner}", response_model=PlannerAnswer, responses=KNOWN | problems(404))
async def show_planner(planner: PlannerName, services: Provided, _user: Caller) -> dict[str, Any]:
    """Show one planner, by its own name."""
    known = {each["name"]: each for each in await services.planners.all()}
    if planner not in known:
        raise NotFound("planner", planner, tuple(known))
    return known[planner]
