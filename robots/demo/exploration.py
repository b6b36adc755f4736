"""The demo of mapping: robots explore an unknown office, one publishes its map, and another one drives on that."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Coroutine
from dataclasses import dataclass, replace
from typing import Any

from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap
from ppaas.maps.new_map import NEW
from ppaas.messages.actionlib_msgs import Status
from robots.cli.explore_progress import ExploreProgress
from robots.client.cloud_url import path_of
from robots.client.explore import ExploreClient, ExploreOutcome
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from robots.demo.mission import Mission
from robots.demo.options import CORES, CloudAccess, DemoOptions, Write
from robots.demo.report import ExplorationReport, RobotReport
from robots.demo.scorer import Scorer, wrong_cells
from robots.sim.courses import Course, CoursePlanner
from robots.sim.driver import Driver
from robots.sim.robot import SimulatedRobot, SimulatedRobotModel
from robots.sim.simulator import Simulator
from robots.sim.world import World

GOALS = 6
"""Goals of the robot that drives on the map."""

EXPLORER, FOLLOWER = "explorer", "follower"
"""Ids of the robots; further ones that explore have numbers behind that of the first."""

HEAD_START = 3.0
"""Time between the connections of two robots that explore [s]."""

LOOK = 1.0
"""Time between two looks whether maps are joined [s]."""

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
    starts : tuple of Pose2D
        Starts of the robots that explore; that of the first is the origin.
    """

    map_id: str
    grid: GridMap
    course: Course
    starts: tuple[Pose2D, ...]


def set_stage(options: DemoOptions) -> ExplorationStage:
    """Take or generate the world, and choose the starts and the goals.

    Raises
    ------
    PPaaSError
        The map is too small.
    """
    map_id, grid = options.map or ("office", office(options.seed, WIDTH, HEIGHT))
    explorers = CoursePlanner(grid, options.seed).choose(max(2, options.explorers), 1)[: options.explorers]
    origin = explorers[0].start.inverse()
    moved = GridMap(grid.data, replace(grid.info, origin=origin @ grid.info.origin))
    [course] = CoursePlanner(moved, options.seed + 1).choose(1, GOALS)
    starts = Pose2D(0.0, 0.0, 0.0), *(origin @ other.start for other in explorers[1:])
    return ExplorationStage(map_id, moved, course, starts)


async def explore_and_drive(options: DemoOptions, cloud: CloudAccess) -> ExplorationReport:
    """Run the demo in a cloud; return its report.

    Raises
    ------
    PPaaSError
        The map or the options are invalid, the cloud rejects the login, or the robot cannot explore.
    """
    stage = await asyncio.to_thread(set_stage, options)
    rest = RestClient(cloud.url)
    await rest.login(cloud.admin, cloud.password)
    began = monotonic()
    explored = await _explore(rest, cloud, stage, options)
    mission = await _drive(rest, cloud, stage, options)
    return _report(stage, explored, mission.close(), monotonic() - began)


@dataclass(frozen=True, slots=True)
class _Explored:
    """Outcomes of the explorations, the map that was made, reports of the robots, and when their maps were joined."""

    outcomes: list[ExploreOutcome]
    made: GridMap
    robots: list[RobotReport]
    joined: float | None


async def _explore(rest: RestClient, access: CloudAccess, stage: ExplorationStage, options: DemoOptions) -> _Explored:
    """Let robots explore the world, and the first one publish the map."""
    world = World(stage.grid, options.seed)
    names = [EXPLORER, *(f"{EXPLORER}-{number}" for number in range(2, len(stage.starts) + 1))]
    for name, start in zip(names, stage.starts, strict=True):
        world.add_robot(start, SimulatedRobotModel())
        await rest.put_robot(name, _robot_file(options, NEW + stage.map_id))
    async with contextlib.AsyncExitStack() as stack:
        joining = asyncio.create_task(_joined(rest, names))
        stack.callback(joining.cancel)
        await stack.enter_async_context(background(Simulator(world).run()))
        operators = []
        for robot, name in zip(world.robots, names, strict=True):
            operators.append(await _connected(stack, access, rest.token or "", robot, name))
            if name != names[-1]:
                await asyncio.sleep(HEAD_START)  # the map is in the frame of the robot that began first
        explorers = [ExploreClient(each, _progress(options.write, name, len(names))) for each, name in operators]
        outcomes = await asyncio.gather(*(each.explore() for each in explorers))
        made = await _published(rest, stage.map_id)
    scorer = Scorer(world)
    robots = [
        RobotReport(name, distance_m=round(scorer.distance(number), 3), collisions=scorer.collisions(number))
        for number, name in enumerate(names)
    ]
    return _Explored(outcomes, made, robots, joining.result() if joining.done() else None)


async def _connected(
    stack: contextlib.AsyncExitStack, access: CloudAccess, token: str, robot: SimulatedRobot, name: str
) -> tuple[RobotClient, str]:
    """Connect a robot and an operator until the stack is closed; return the operator, and the name."""
    client = await stack.enter_async_context(RobotClient(access.url, robot=name, token=token))
    await stack.enter_async_context(background(Driver(robot, client).run()))
    return await stack.enter_async_context(RobotClient(access.url, robot=name, token=token, role="operator")), name


async def _joined(rest: RestClient, names: list[str]) -> float | None:
    """Wait until the map of the first robot is one with those of all others; return the time that it took [s]."""
    began = monotonic()
    while len(names) > 1:
        await asyncio.sleep(LOOK)
        with contextlib.suppress(PPaaSError):
            if len((await rest.get(path_of("robots", EXPLORER, "map")))["joined_with"]) == len(names) - 1:
                return monotonic() - began
    return None


def _progress(write: Write, name: str, robots: int) -> ExploreProgress:
    """Return what writes the progress of a robot, with its name if there are several."""
    return ExploreProgress(write if robots == 1 else lambda line: write(f"{name:12}{line}"))


async def _published(rest: RestClient, map_id: str) -> GridMap:
    """Publish the map that the explorer has made, and return it as other robots get it."""
    await rest.with_timeout(PUBLISH_TIMEOUT).post(path_of("robots", EXPLORER, "map"), {"publish": map_id})
    yaml, image = [await rest.fetch(path_of("maps", map_id, part)) for part in ("yaml", "image")]
    return load_map(yaml, image)


async def _drive(rest: RestClient, access: CloudAccess, stage: ExplorationStage, options: DemoOptions) -> Mission:
    world = World(stage.grid, options.seed + 1)
    world.add_robot(stage.course.start, SimulatedRobotModel())
    mission = Mission(world, 0, FOLLOWER, stage.course, options.write)
    await rest.put_robot(FOLLOWER, _robot_file(options, stage.map_id, stage.course.start))
    options.write(f"{FOLLOWER} drives to {GOALS} goals on the published map")
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
    results = [outcome.result for outcome in explored.outcomes]
    worst = next(
        (outcome.status for outcome in explored.outcomes if outcome.status != Status.SUCCEEDED), Status.SUCCEEDED
    )
    wrong, known = wrong_cells(explored.made, stage.grid)
    return ExplorationReport(
        map=stage.map_id,
        seconds=round(seconds, 2),
        explored=worst.name.lower(),
        explored_seconds=round(max(result.exploration_time.seconds() for result in results), 2),
        frontiers=max(result.frontiers for result in results),
        unreachable=max(result.unreachable for result in results),
        area_m2=round(known * explored.made.info.resolution**2, 2),
        known_cells=known,
        wrong_cells=wrong,
        robots=[*explored.robots, drove],
        joined_seconds=None if explored.joined is None else round(explored.joined, 1),
    )


# -- background --------------------------------------------------------------------------------------------------------


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
