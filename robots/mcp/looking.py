"""Tools that look: robots, their states and goals, maps, paths and tasks. They change nothing."""

import base64
import io
from typing import Annotated, Any, Literal

from mcp_types import ContentBlock, ImageContent, TextContent
from pydantic import Field

from ppaas.errors import InvalidInput, NoValidPath, Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from robots.client.cloud_url import path_of
from robots.mcp.answers import GoalShown, MapList, MapRow, PathShown, RobotList, RobotRow, RobotShown, TaskList, TaskRow
from robots.mcp.narrowed_cloud import NarrowedCloud, length
from robots.mcp.tool import (
    MOST_ROWS,
    Arguments,
    GoalName,
    MapName,
    Metres,
    Progress,
    Radians,
    RobotAddress,
    RobotTool,
    Rows,
)
from robots.pictures.scene import draw_scene

MOST_CELLS = 1 << 26
"""Largest map that is drawn [cells]."""

MOST_ROBOTS = 1000
"""Largest number of robots among which those on the drawn map are looked for."""

MOST_POSES = 100
"""Largest number of poses of a path that are returned."""


class ListArguments(Arguments):
    """Arguments of a list."""

    most: Rows = MOST_ROWS


class RobotArguments(Arguments):
    """Arguments that name a robot."""

    robot: RobotAddress


class GoalArguments(RobotArguments):
    """Arguments that name a goal."""

    goal: GoalName


class PictureArguments(Arguments):
    """Arguments of a picture."""

    map: MapName
    size: Annotated[int, Field(ge=100, le=1600, description="Longest side of the map in the picture [pixels]")] = 800


class PathArguments(RobotArguments):
    """Arguments of a path."""

    x: Annotated[Metres, Field(description="x of the goal [m] in the frame of the robot's map")]
    y: Annotated[Metres, Field(description="y of the goal [m]")]
    yaw: Annotated[Radians, Field(description="Heading at the goal [rad], counter-clockwise from x")] = 0.0
    start: (
        Annotated[list[Metres], Field(min_length=2, max_length=3, description="x, y [m] and, optionally, yaw [rad]")]
        | None
    ) = Field(None, description="Where the path begins; null for the place of the robot")
    tolerance: Annotated[
        float, Field(ge=0.0, le=100.0, description="If the goal is blocked, plan to a free place this near [m]")
    ] = 0.0


class TaskArguments(Arguments):
    """Arguments of a list of tasks."""

    map: MapName
    state: Literal["open", "queued", "assigned", "active", "done", "failed", "cancelled"] | None = Field(
        "open", description="Only tasks in this state; open: all that have not ended; null: all"
    )
    most: Rows = MOST_ROWS


async def _list_robots(cloud: NarrowedCloud, arguments: ListArguments, _progress: Progress) -> RobotList:
    rows = await cloud.robots(arguments.most)
    found = [RobotRow.model_validate(row | {"robot": row["address"]}) for row in rows[: arguments.most]]
    return RobotList(robots=found, more=len(rows) > arguments.most)


async def _robot_state(cloud: NarrowedCloud, arguments: RobotArguments, _progress: Progress) -> RobotShown:
    path = cloud.path(arguments.robot)
    described, state = await cloud.rest.get(path), await cloud.rest.get(f"{path}/state")
    both = {"robot": arguments.robot, "map": described["map"], "stopped": described["stopped"]}
    return RobotShown.model_validate(state | both)


async def _goal_state(cloud: NarrowedCloud, arguments: GoalArguments, _progress: Progress) -> GoalShown:
    return GoalShown.model_validate(await cloud.rest.get(cloud.path(arguments.robot, "goals", arguments.goal)))


async def _list_maps(cloud: NarrowedCloud, arguments: ListArguments, _progress: Progress) -> MapList:
    rows = await cloud.rest.items(path_of("maps"), arguments.most + 1)
    found = [MapRow.model_validate(row) for row in rows[: arguments.most]]
    return MapList(maps=found, more=len(rows) > arguments.most)


async def _map_picture(cloud: NarrowedCloud, arguments: PictureArguments, _progress: Progress) -> list[ContentBlock]:
    path = path_of("maps", arguments.map)
    described = await cloud.rest.get(path)
    if described["width"] is None:
        raise InvalidInput(f"map {arguments.map!r} has no grid to draw")
    if described["width"] * described["height"] > MOST_CELLS:
        raise InvalidInput(
            f"map {arguments.map!r} has {described['width']} × {described['height']} cells: maps with more than "
            f"{MOST_CELLS} cells are not drawn"
        )
    grid = load_map(await cloud.rest.fetch(f"{path}/yaml"), await cloud.rest.fetch(f"{path}/image"))
    zones = await cloud.rest.fetch(f"{path}/zones") if "zones" in described["parts"] else None
    rows = await cloud.robots(MOST_ROBOTS)
    robots = {
        row["address"]: Pose2D(*row["pose"])
        for row in rows[:MOST_ROBOTS]
        if row["map"] == arguments.map and row["pose"] is not None
    }
    rest = f" (of the first {MOST_ROBOTS} robots alone)" if len(rows) > MOST_ROBOTS else ""
    image = draw_scene(grid, zones, robots, arguments.size)
    file = io.BytesIO()
    image.picture.save(file, "PNG")
    return [
        TextContent(text=_caption(arguments.map, image.scale, robots) + f"{rest}."),
        ImageContent(data=base64.b64encode(file.getvalue()).decode(), mime_type="image/png"),
    ]


def _caption(map_id: str, scale: float, robots: dict[str, Pose2D]) -> str:
    shown = "; ".join(f"{name} at x {pose.x:.2f}, y {pose.y:.2f}" for name, pose in robots.items()) or "none known"
    return (
        f"Map {map_id}: x to the right, y up, with lines each few metres labelled in the frame of the map; a pixel is "
        f"{scale:.3g} m. White is free, black an obstacle, grey unknown; coloured areas are zones. Robots: {shown}"
    )


async def _plan_path(cloud: NarrowedCloud, arguments: PathArguments, _progress: Progress) -> PathShown:
    state = await cloud.rest.get(cloud.path(arguments.robot, "state"))
    if not state["connected"]:
        raise Unavailable(f"robot {arguments.robot} is not connected, so its clone plans no path")
    start = None if arguments.start is None else Pose2D(*arguments.start)
    goal = Pose2D(arguments.x, arguments.y, arguments.yaw)
    path = await cloud.planned(arguments.robot, start, goal, arguments.tolerance)
    if not path:
        raise NoValidPath(f"there is no path for {arguments.robot} to x {goal.x:g}, y {goal.y:g}")
    step = max(1, -(-(len(path) - 1) // (MOST_POSES - 1)))
    kept = [*path[:-1:step], path[-1]]
    return PathShown(length=round(length(path), 3), poses=[[round(number, 3) for number in pose] for pose in kept])


async def _list_tasks(cloud: NarrowedCloud, arguments: TaskArguments, _progress: Progress) -> TaskList:
    filters: dict[str, Any] = {} if arguments.state is None else {"state": arguments.state}
    rows = await cloud.rest.items(path_of("maps", arguments.map, "tasks"), arguments.most + 1, **filters)
    served = [row for row in rows[: arguments.most] if row["robot"] is None or cloud.serves(row["robot"])]
    return TaskList(tasks=[TaskRow.model_validate(row) for row in served], more=len(rows) > arguments.most)


TOOLS = (
    RobotTool(
        "list_robots", "List robots", "List the robots: where each is, what it does, and what is wrong with it.",
        "looks", ListArguments, RobotList, _list_robots,
    ),
    RobotTool(
        "robot_state", "Show a robot", "Show where a robot is now, its active goals, and whether somebody stopped it.",
        "looks", RobotArguments, RobotShown, _robot_state,
    ),
    RobotTool(
        "goal_state", "Show a goal", "Show what became of a goal that go_to has sent.",
        "looks", GoalArguments, GoalShown, _goal_state,
    ),
    RobotTool("list_maps", "List maps", "List the maps that may be read.", "looks", ListArguments, MapList, _list_maps),
    RobotTool(
        "map_picture", "Show a map",
        "Show the picture of a map with its zones and robots, and with coordinates, to find places for goals.",
        "looks", PictureArguments, None, _map_picture,
    ),
    RobotTool(
        "plan_path", "Plan a path",
        "Plan the path of a connected robot to a place, around zones and obstacles that it sees. It does not drive.",
        "looks", PathArguments, PathShown, _plan_path,
    ),
    RobotTool(
        "list_tasks", "List tasks", "List the tasks of a map, which any of its robots may do, oldest first.",
        "looks", TaskArguments, TaskList, _list_tasks,
    ),
)  # fmt: skip
"""Tools that look."""
