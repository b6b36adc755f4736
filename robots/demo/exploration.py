"""The demo of mapping: a robot explores an unknown office and publishes its map, on which another one drives."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable, Coroutine
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from ppaas.clock import monotonic
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap
from ppaas.maps.new_map import NEW
from robots.cli.explore_progress import ExploreProgress
from robots.client.explore import ExploreClient, ExploreOutcome
from robots.client.map_files import read_map_file
from robots.client.rest import RestClient
from robots.client.rest_paths import path_of
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from robots.demo.demonstration import CORES, CloudAccess, DemoOptions, own_cloud, waiting
from robots.demo.map_score import wrong_cells
from robots.demo.mission import Mission
from robots.demo.report import ExplorationReport, RobotReport
from robots.demo.scorer import Scorer
from robots.sim.courses import Course, CoursePlanner
from robots.sim.driver import Driver
from robots.sim.robot import SimulatedRobotModel
from robots.sim.simulator import Simulator
from robots.sim.world import World

GOALS = 6
"""Goals of the robot that drives on the map."""

EXPLORER, FOLLOWER = "explorer", "follower"
"""Ids of the two robots."""

PUBLISH_TIMEOUT = 300.0
"""Time limit of the publication [s]: the map is refined and drawn."""

WIDTH, HEIGHT = 14.0, 11.0
"""Size of the generated office [m]."""


@dataclass(frozen=True, slots=True)
class ExplorationStage:
    """World of the demo, in the frame of the map that is to be made: that of the first pose of the explorer.

    Parameters
    ----------
    map_id : str
        Id under which the map is published.
    grid : GridMap
        The true world.
    course : Course
        Start and goals of the robot that drives on the map.
    """

    map_id: str
    grid: GridMap
    course: Course


def set_stage(options: DemoOptions) -> ExplorationStage:
    """Load or generate the world, and choose the starts and the goals.

    Raises
    ------
    PPaaSError
        The map cannot be read, or is too small.
    """
    path = options.map_path
    grid = read_map_file(path) if path else office(options.seed, WIDTH, HEIGHT)
    explorer, _ = CoursePlanner(grid, options.seed).choose(2, 1)
    moved = GridMap(grid.data, replace(grid.info, origin=explorer.start.inverse() @ grid.info.origin))
    [course] = CoursePlanner(moved, options.seed + 1).choose(1, GOALS)
    return ExplorationStage(path.stem if path else "office", moved, course)


async def explore_and_drive(options: DemoOptions) -> ExplorationReport:
    """Run the demo in the given cloud or in a new one; return its report.

    Raises
    ------
    PPaaSError
        The map or the options are invalid, the cloud does not start or rejects the login, or the robot cannot explore.
    """
    async with contextlib.AsyncExitStack() as stack:
        with waiting(options.console):
            stage = await asyncio.to_thread(set_stage, options)
            access = options.cloud or await own_cloud(stack)
        rest = RestClient(access.url)
        await rest.login(access.admin, access.password)
        began = monotonic()
        explored = await _explore(rest, access, stage, options)
        mission = await _drive(rest, access, stage, options)
    return _report(stage, explored, mission.close(), monotonic() - began)


@dataclass(frozen=True, slots=True)
class _Explored:
    """Outcome of the exploration, the map that was made, and the report of the robot."""

    outcome: ExploreOutcome
    made: GridMap
    robot: RobotReport


async def _explore(rest: RestClient, access: CloudAccess, stage: ExplorationStage, options: DemoOptions) -> _Explored:
    """Let the first robot explore the world and publish the map."""
    world = World(stage.grid, options.seed)
    world.add_robot(Pose2D(0.0, 0.0, 0.0), SimulatedRobotModel())
    await rest.put_robot(EXPLORER, _robot_file(options, NEW + stage.map_id))
    token, lines = rest.token or "", _lines(options)
    async with (
        background(Simulator(world).run()),
        RobotClient(access.url, robot=EXPLORER, token=token) as client,
        background(Driver(world.robots[0], client).run()),
        RobotClient(access.url, robot=EXPLORER, token=token, role="operator") as operator,
    ):
        progress = None if lines is None else ExploreProgress(lines)
        outcome = await ExploreClient(operator, progress).explore()
        made = await _published(rest, stage.map_id)
    scorer = Scorer(world)
    robot = RobotReport(EXPLORER, distance_m=round(scorer.distance(0), 3), collisions=scorer.collisions(0))
    return _Explored(outcome, made, robot)


async def _published(rest: RestClient, map_id: str) -> GridMap:
    """Publish the map that the explorer has made, and return it as other robots get it."""
    await rest.with_timeout(PUBLISH_TIMEOUT).post(path_of("robots", EXPLORER, "map"), {"publish": map_id})
    yaml, image = [await rest.fetch(path_of("maps", map_id, part)) for part in ("yaml", "image")]
    return load_map(yaml, image)


async def _drive(rest: RestClient, access: CloudAccess, stage: ExplorationStage, options: DemoOptions) -> Mission:
    """Let the second robot drive to its goals on the published map."""
    world = World(stage.grid, options.seed + 1)
    world.add_robot(stage.course.start, SimulatedRobotModel())
    mission = Mission(world, 0, FOLLOWER, stage.course)
    await rest.put_robot(FOLLOWER, _robot_file(options, stage.map_id, stage.course.start))
    if (write := _lines(options)) is not None:
        write(f"{FOLLOWER} drives to {GOALS} goals on the published map")
    async with background(Simulator(world).run()):
        await mission.run(access.url, rest.token or "")
    return mission


def _robot_file(options: DemoOptions, map_id: str, start: Pose2D = Pose2D(0.0, 0.0, 0.0)) -> RobotFile:
    return RobotFile(
        map=map_id,
        initial_pose=(start.x, start.y, start.theta),
        cores=CORES,
        base_global_planner=options.planner,
        base_local_planner=options.controller,
    )


def _report(stage: ExplorationStage, explored: _Explored, drove: RobotReport, seconds: float) -> ExplorationReport:
    result = explored.outcome.result
    wrong, known = wrong_cells(explored.made, stage.grid)
    return ExplorationReport(
        map=stage.map_id,
        seconds=round(seconds, 2),
        explored=explored.outcome.status.name.lower(),
        explored_seconds=round(result.exploration_time.seconds(), 2),
        frontiers=result.frontiers,
        unreachable=result.unreachable,
        area_m2=round(known * explored.made.info.resolution**2, 2),
        known_cells=known,
        wrong_cells=wrong,
        robots=[explored.robot, drove],
    )


# -- background --------------------------------------------------------------------------------------------------------


def _lines(options: DemoOptions) -> Callable[[str], None] | None:
    """Return what writes lines of progress, if there is a terminal for them."""
    console = options.console
    return None if console is None else partial(console.print, highlight=False, markup=False)


@contextlib.asynccontextmanager
async def background(work: Coroutine[Any, Any, None]) -> AsyncIterator[None]:
    """Run a coroutine during the block; if it fails, the block is cancelled and its error is raised."""
    try:
        async with asyncio.TaskGroup() as group:
            task = group.create_task(work)
            yield
            task.cancel()
    except BaseExceptionGroup as errors:
        raise errors.exceptions[0] from None
