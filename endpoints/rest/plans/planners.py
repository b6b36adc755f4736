"""Routes that list the installed planners."""

from typing import Any, Literal

from fastapi import APIRouter
from pydantic import BaseModel, Field

from endpoints.rest.dependencies import AnyCaller, Provided
from endpoints.rest.names import PlannerName
from endpoints.rest.openapi import KNOWN, problems
from ppaas.errors import NotFound

router = APIRouter(prefix="/planners", tags=["planners"])


class PlannerAnswer(BaseModel):
    """A planner."""

    name: str
    aliases: list[str] = Field(description="ROS names of this planner or of one of its kind")
    purpose: str = Field(description="When to choose this planner")
    parameters: dict[str, Any] = Field(description="Parameters that a robot file may set, with defaults")
    optimal: Literal["always", "uniform", "never"] = Field(
        description="Whether its paths are cheapest: on any costs, only on uniform costs, or not guaranteed"
    )
    weighted: bool = Field(description="Whether it takes the costs of free cells into account")
    any_angle: bool = Field(description="Whether paths may run in any direction")
    kinematic: bool = Field(description="Whether a robot that cannot turn in place can follow its paths")
    indexed: bool = Field(description="Whether it preprocesses a map once for many queries")
    incremental: bool = Field(description="Whether replanning after a change of the map takes less work")
    dimensions: int = Field(description="Dimensions of the maps it plans on")


class PlannerPage(BaseModel):
    """All planners, on a single page."""

    items: list[PlannerAnswer]
    next: None = None


@router.get("", response_model=PlannerPage, responses=KNOWN)
async def list_planners(services: Provided, _user: AnyCaller) -> dict[str, Any]:
    """List the planners that robot files and path requests may name."""
    return {"items": await services.planners.all()}


@router.get("/{planner}", response_model=PlannerAnswer, responses=KNOWN | problems(404))
async def show_planner(planner: PlannerName, services: Provided, _user: AnyCaller) -> dict[str, Any]:
    """Show one planner, by its own name."""
    by_name = {each["name"]: each for each in await services.planners.all()}
    if planner not in by_name:
        raise NotFound("planner", planner, tuple(by_name))
    return by_name[planner]
