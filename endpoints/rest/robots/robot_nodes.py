"""Routes of a robot's nodes: whether each runs in the cloud or on the robot, and why."""

from typing import Annotated, Literal

from fastapi import APIRouter, Path
from pydantic import Field

from endpoints.rest.dependencies import Administered, Looked, Paged, Provided
from endpoints.rest.names import Name
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import RequestBody, ResponseBody
from endpoints.rest.strict_json import StrictRoute
from ppaas.messages.ppaas_msgs import NodeHome

router = APIRouter(prefix="/robots/{robot_id}/nodes", tags=["robots"], route_class=StrictRoute)

Home = Literal["cloud", "robot"]
NodeName = Annotated[Name, Path(examples=["move_base"])]


class NodeAnswer(ResponseBody):
    """Node of a robot."""

    node: str
    home: Home = Field(description="Home of the node: where it runs")
    wanted: Home = Field(description="Home that was decided; a connected robot takes the node over within a second")
    score: float = Field(description="Score from -1, entirely for the robot, to 1, entirely for the cloud")
    reasons: list[str] = Field(description="Reasons of the decision, most important first")


class NodeRequest(RequestBody):
    """Home to run a node in."""

    home: Home | None = Field(default=None, description="Home of the node; null: the node monitor decides")


@router.get("", response_model=Page[NodeAnswer], responses=KNOWN | problems(403, 404, 503))
async def list_nodes(robot: Looked, services: Provided, paging: Paged) -> dict[str, object]:
    """List the nodes of a connected robot by name, with their homes and the reasons."""
    homes = sorted(await services.cloud.nodes.homes(robot.user, robot.id), key=lambda home: home.node)
    after = paging.key(str, "")
    return paging.page([home for home in homes if home.node > after], lambda home: home.node)


@router.post("/{node}", response_model=NodeAnswer, responses=KNOWN | BODY | problems(403, 404, 503))
async def run_node(robot: Administered, node: NodeName, request: NodeRequest, services: Provided) -> NodeHome:
    """Move a node of a robot to a home, or let the node monitor choose its home."""
    return await services.cloud.nodes.run(robot.user, robot.id, node, request.home or "")
