"""Routes of navigation: pose and goals of a connected robot, for fleet adapters and programs without a WebSocket."""

from typing import Annotated

from fastapi import APIRouter, Path
from pydantic import ConfigDict, Field

from endpoints.resources.services import Services
from endpoints.rest.dependencies import Driven, Looked, Paged, Provided
from endpoints.rest.names import Name
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import Pose, RequestBody, ResponseBody, Triple, triple
from endpoints.rest.strict_json import StrictRoute
from endpoints.sharing.access import GOALS, LOCALIZATION, in_words, may_hear
from endpoints.sharing.shared_robots import ReachedRobot
from engine.control.journeys.calls import ON_FLOORS, JourneyCalls
from engine.control.views import GoalState, GoalView
from ppaas.errors import NotFound, Unavailable
from ppaas.geometry import Pose2D

router = APIRouter(prefix="/robots/{robot_id}", tags=["robots"], route_class=StrictRoute)

MOVE_BASE = "move_base"
"""Action to which goals are sent."""

GoalId = Annotated[Name, Path(examples=["rest-8f0c2d51a9be"])]


class GoalAnswer(ResponseBody):
    """Goal of a robot."""

    id: str
    pose: Triple
    state: GoalState = Field(description="`lost`: the robot's clone does not know the goal any more; send it again")
    text: str = Field(description="Reason for a wait, or for the end of the goal")
    sent: float = Field(description="Time at which it was sent [s since the epoch]")
    ended: float | None = Field(description="Time at which it ended [s since the epoch]; null while it is active")


class StateAnswer(ResponseBody):
    """Pose and active goals of a robot."""

    connected: bool = Field(description="Whether the robot's own socket is open at an endpoint")
    disconnected_since: float | None = Field(
        description="Time at which that was lost [s since the epoch]; null while the robot is connected, or if the "
        "cloud has not known it since it was started"
    )
    container: bool = Field(
        description="Whether the robot has a container, which waits for a robot that has left, or was opened by an "
        "operator"
    )
    pose: Triple | None = Field(description="Estimated pose in the frame of the map; null before localization")
    pose_at: float | None = Field(description="Time at which the pose was received [s since the epoch]")
    localization: str | None = Field(
        description="Reason why the pose is not renewed; empty if it is; null if the caller may "
        f"not read {in_words(LOCALIZATION)}"
    )
    goals: list[GoalAnswer] | None = Field(
        description=f"Goals that have not ended, oldest first; null if the caller may not read {in_words(GOALS)}"
    )


class GoalRequest(RequestBody):
    """Goal to send."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"pose": [4.0, 1.5, 1.57]}]})

    pose: Pose
    floor: Annotated[
        str | None,
        Field(
            max_length=64,
            description="Floor on whose map the pose is, of the building that the robot's map is a floor of; by "
            "default the robot's map",
        ),
    ] = None


@router.get("/state", response_model=StateAnswer, responses=KNOWN | problems(403, 404))
async def show_state(robot: Looked, services: Provided) -> StateAnswer:
    """Show the pose and the active goals of a robot."""
    state = StateAnswer.model_validate(await services.cloud.robots.state(robot.user, robot.id))
    hidden = {"goals": GOALS, "localization": LOCALIZATION}
    return state.model_copy(update={part: None for part, names in hidden.items() if not may_hear(robot.access, names)})


@router.post(
    "/goals", status_code=201, response_model=GoalAnswer, responses=KNOWN | BODY | problems(403, 404, 429, 503)
)
async def send_goal(robot: Driven, request: GoalRequest, services: Provided) -> GoalView:
    """Send a connected robot to a pose; its earlier goal is cancelled, as in ROS.

    With a floor, the robot takes lifts, doors and ramps of its building on the way.
    """
    robot.access.check_goal(MOVE_BASE)
    pose = Pose2D(*triple(request.pose))
    if request.floor is not None:
        return await _journeys(services).send_to_floor(robot.user, robot.id, request.floor, pose)
    await _cancel_journeys(robot, services)
    return await services.cloud.robots.send_goal(robot.user, robot.id, pose)


@router.get("/goals", response_model=Page[GoalAnswer], responses=KNOWN | problems(403, 404))
async def list_goals(robot: Looked, services: Provided, paging: Paged) -> dict[str, object]:
    """List the goals that were sent by REST since the robot connected, by time; ended goals are kept for a while."""
    after = paging.key(float, 0.0)
    sent = [*await services.cloud.robots.goals(robot.user, robot.id), *await _on_floors(robot, services)]
    goals = [goal for goal in sorted(sent, key=lambda goal: goal.sent) if goal.sent > after]
    return paging.page(goals, lambda goal: goal.sent)


async def _on_floors(robot: ReachedRobot, services: Services) -> list[GoalView]:
    """Return the goals on floors that a robot was sent to; none where no master leads them."""
    return [] if services.journeys is None else await services.journeys.journeys(robot.user, robot.id)


@router.get("/goals/{goal_id}", response_model=GoalAnswer, responses=KNOWN | problems(403, 404))
async def show_goal(robot: Looked, goal_id: GoalId, services: Provided) -> GoalView:
    """Show a goal."""
    if goal_id.startswith(ON_FLOORS):
        found = (goal for goal in await _on_floors(robot, services) if goal.id == goal_id)
        goal = next(found, None)
        if goal is None:
            raise NotFound("goal", goal_id)
        return goal
    return await services.cloud.robots.goal(robot.user, robot.id, goal_id)


@router.delete(
    "/goals/{goal_id}", status_code=202, response_model=GoalAnswer, responses=KNOWN | problems(403, 404, 409, 503)
)
async def cancel_goal(robot: Driven, goal_id: GoalId, services: Provided) -> GoalView:
    """Cancel a goal; it ends as `canceled` once the robot's clone has stopped it."""
    robot.access.check_goal(MOVE_BASE)
    if goal_id.startswith(ON_FLOORS):
        return await _journeys(services).cancel_journey(robot.user, robot.id, goal_id)
    return await services.cloud.robots.cancel_goal(robot.user, robot.id, goal_id)


@router.delete("/goals", status_code=202, responses=KNOWN | problems(403, 404, 503))
async def cancel_goals(robot: Driven, services: Provided) -> None:
    """Cancel all goals of a robot, also those that were not sent by REST: the robot stops."""
    robot.access.check_goal(MOVE_BASE)
    await _cancel_journeys(robot, services)
    await services.cloud.robots.cancel_goals(robot.user, robot.id)


async def _cancel_journeys(robot: ReachedRobot, services: Services) -> None:
    for goal in await _on_floors(robot, services):
        if goal.ended is None:
            await _journeys(services).cancel_journey(robot.user, robot.id, goal.id)


def _journeys(services: Services) -> JourneyCalls:
    if services.journeys is None:
        raise Unavailable("no master leads robots over floors for this endpoint")
    return services.journeys
