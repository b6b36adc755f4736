"""Tools that drive a robot, stop it, and release it."""

import asyncio
import logging
from typing import Annotated, Any

from anyio import CancelScope
from pydantic import Field

from ppaas.clock import monotonic
from ppaas.errors import PPaaSError, Unavailable
from robots.mcp.answers import Cancelled, GoalShown, Released, Stopped
from robots.mcp.narrowed_cloud import NarrowedCloud
from robots.mcp.tool import Arguments, GoalName, Metres, Progress, Radians, RobotAddress, RobotTool

logger = logging.getLogger(__name__)

POLL = 0.5
"""Interval of queries while a goal is followed [s]."""

ACTIVE = ("pending", "active")

DEFAULT_WAIT = 45.0
"""Time for which a call follows its goal by default [s]: less than the minute after which clients give up."""

Reason = Annotated[str, Field(max_length=200, description="Why, for people who read it later")]


class TargetArguments(Arguments):
    """Arguments of a goal."""

    robot: RobotAddress
    x: Annotated[Metres, Field(description="x [m] in the frame of the robot's map")]
    y: Annotated[Metres, Field(description="y [m]")]
    yaw: Annotated[Radians, Field(description="Heading at the goal [rad], counter-clockwise from x")] = 0.0
    wait: Annotated[
        float,
        Field(
            ge=0.0,
            le=3600.0,
            description="Time for which this call waits for the end of the goal [s]; then it returns the goal as it "
            "is, and the robot drives on: see goal_state. Cancelling the call before cancels the goal.",
        ),
    ] = DEFAULT_WAIT


class CancelArguments(Arguments):
    """Arguments of a cancellation."""

    robot: RobotAddress
    goal: GoalName | None = Field(None, description="Goal to cancel; null for all goals of the robot")


class StopArguments(Arguments):
    """Arguments of a stop or a release."""

    robot: RobotAddress
    reason: Reason = ""


async def _go_to(cloud: NarrowedCloud, arguments: TargetArguments, progress: Progress) -> GoalShown:
    path = cloud.path(arguments.robot, "goals")
    goal = await _sent(cloud, path, [arguments.x, arguments.y, arguments.yaw])
    try:
        return GoalShown.model_validate(await _followed(cloud, arguments, goal, progress))
    except asyncio.CancelledError:
        with CancelScope(shield=True):
            await _cancel_left(cloud, f"{path}/{goal['id']}")
        raise


async def _sent(cloud: NarrowedCloud, path: str, pose: list[float]) -> dict[str, Any]:
    """Send a goal, and return it; a call that is cancelled meanwhile waits for its name, and cancels it."""
    posting = asyncio.ensure_future(cloud.rest.post(path, {"pose": pose}))
    try:
        goal: dict[str, Any] = await asyncio.shield(posting)
    except asyncio.CancelledError:
        with CancelScope(shield=True):
            await asyncio.wait({posting})
            if posting.exception() is None:
                await _cancel_left(cloud, f"{path}/{posting.result()['id']}")
        raise
    return goal


async def _followed(
    cloud: NarrowedCloud, arguments: TargetArguments, goal: dict[str, Any], progress: Progress
) -> dict[str, Any]:
    """Return a goal when it has ended, or after the time to wait.

    Raises
    ------
    Unavailable
        The cloud was away until then; the text has the id of the goal, since the robot may drive.
    """
    path, began, away = cloud.path(arguments.robot), monotonic(), ""
    while goal["state"] in ACTIVE and (waited := monotonic() - began) < arguments.wait:
        try:
            words, away = await _standing(cloud, path, goal), ""
            await progress(waited, arguments.wait, words)
            await asyncio.sleep(min(POLL, max(0.0, arguments.wait - waited)))
            goal = await cloud.rest.get(f"{path}/goals/{goal['id']}")
        except Unavailable as error:
            away = str(error)
            await progress(waited, arguments.wait, away)
            await asyncio.sleep(POLL)
    if away:
        raise Unavailable(f"goal {goal['id']} was sent, and how far it is cannot be seen now: {away}")
    return goal


async def _standing(cloud: NarrowedCloud, path: str, goal: dict[str, Any]) -> str:
    """Return how far a goal is, in words."""
    pose = (await cloud.rest.get(f"{path}/state"))["pose"]
    place = "" if pose is None else f", at x {pose[0]:.2f}, y {pose[1]:.2f}"
    return f"{goal['state']}{place}{': ' if goal['text'] else ''}{goal['text']}"


async def _cancel_left(cloud: NarrowedCloud, path: str) -> None:
    """Cancel the goal of a call whose client has gone: nobody waits for an error, so it is logged."""
    try:
        await cloud.rest.delete(path)
    except PPaaSError as error:
        logger.warning("the goal of a cancelled call is not cancelled: %s", error)


async def _cancel_goals(cloud: NarrowedCloud, arguments: CancelArguments, _progress: Progress) -> Cancelled:
    path = cloud.path(arguments.robot, "goals")
    if arguments.goal is not None:
        one = f"{path}/{arguments.goal}"
        await cloud.rest.delete(one)
        return Cancelled(goals=[GoalShown.model_validate(await cloud.rest.get(one))])
    state = await cloud.rest.get(cloud.path(arguments.robot, "state"))
    await cloud.rest.delete(path)
    return Cancelled(goals=[GoalShown.model_validate(goal) for goal in state["goals"] or ()])


async def _stop_robot(cloud: NarrowedCloud, arguments: StopArguments, _progress: Progress) -> Stopped:
    answer = await cloud.rest.post(cloud.path(arguments.robot, "stop"), {"reason": arguments.reason})
    return Stopped.model_validate(answer)


async def _release_robot(cloud: NarrowedCloud, arguments: StopArguments, _progress: Progress) -> Released:
    answer = await cloud.rest.post(cloud.path(arguments.robot, "release"), {"reason": arguments.reason})
    return Released.model_validate(answer)


TOOLS = (
    RobotTool(
        "go_to", "Send a robot",
        "Send a robot to a pose on its map, and wait for the end of the goal. Its earlier goal is replaced. Look at "
        "the state of the returned goal: only succeeded means that the robot is there.",
        "drives", TargetArguments, GoalShown, _go_to,
    ),
    RobotTool(
        "cancel_goals", "Cancel goals", "Cancel a goal of a robot, or all: the robot stops, and takes new goals.",
        "stops", CancelArguments, Cancelled, _cancel_goals,
    ),
    RobotTool(
        "stop_robot", "Stop a robot",
        "Stop a robot at once, until a person releases it; its goals wait. For danger: else cancel its goals.",
        "stops", StopArguments, Stopped, _stop_robot,
    ),
    RobotTool(
        "release_robot", "Release a robot", "Release a stopped robot: it drives on to its goals at once.",
        "releases", StopArguments, Released, _release_robot,
    ),
)  # fmt: skip
"""Tools that drive."""
