"""The whole way in one place: a cloud, a map, simulated robots with goals, and a scorer."""

import asyncio
import contextlib
import signal
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from ppaas.clock import monotonic
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap
from robots.client.map_files import read_map_file
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from robots.demo.cloud_process import CloudProcess
from robots.demo.mission import Mission
from robots.demo.progress_view import show
from robots.demo.report import DemoReport
from robots.sim.courses import CoursePlanner
from robots.sim.robot import SimulatedRobotModel
from robots.sim.simulator import Simulator
from robots.sim.world import World

CORES = 0.5
"""Size of a robot's container: most of the time it waits for the next scan."""


@dataclass(frozen=True, slots=True)
class DemoOptions:
    """What to demonstrate.

    Parameters
    ----------
    robots, goals : int
        How many robots, and goals for each.
    seed : int
        Of the courses, of what is left to chance in the world, and of the warehouse if there is no map.
    map_path : Path, optional
        YAML file of a map; without it a warehouse is made.
    keep_going : bool
        Drive the courses again and again, until interrupted.
    console : Console, optional
        Where to show progress; nowhere by default.
    planner, controller : str
        Move Base's global and local planner.
    cloud : CloudAccess, optional
        A cloud that is up already; without it one is started.
    """

    robots: int = 3
    goals: int = 2
    seed: int = 0
    map_path: Path | None = None
    keep_going: bool = False
    console: Console | None = None
    planner: str = "dijkstra"
    controller: str = "dwa"
    cloud: "CloudAccess | None" = None


@dataclass(frozen=True, slots=True)
class CloudAccess:
    """How a cloud is reached, and who may do everything in it."""

    url: str
    admin: str
    password: str


@dataclass(frozen=True, slots=True)
class Stage:
    """What is set up before the cloud starts."""

    map_id: str
    grid: GridMap
    world: World
    missions: list[Mission]


def set_stage(options: DemoOptions) -> Stage:
    """Load or make the map, choose the courses and put the robots at their starts.

    Raises
    ------
    PPaaSError
        The map cannot be read, or has no room for so many.
    """
    path = options.map_path
    grid = read_map_file(path) if path else warehouse(options.seed)
    courses = CoursePlanner(grid, options.seed).choose(options.robots, options.goals)
    world = World(grid, options.seed)
    missions = []
    for index, course in enumerate(courses):
        world.add_robot(course.start, SimulatedRobotModel())
        missions.append(Mission(world, index, f"turtlebot-{index + 1}", course))
    return Stage(path.stem if path else "warehouse", grid, world, missions)


async def demonstrate(options: DemoOptions) -> DemoReport:
    """Run the demo in the cloud given, or in one of its own; return how it went.

    Raises
    ------
    PPaaSError
        The map or the options will not do, or the cloud does not start, or does not let us in.
    """
    async with contextlib.AsyncExitStack() as stack:
        with _waiting(options.console):
            stage = await asyncio.to_thread(set_stage, options)
            access = options.cloud or await _own_cloud(stack)
        rest = RestClient(access.url)
        login = await rest.login(access.admin, access.password)
        await introduce(rest, stage, options)
        began = monotonic()
        async with _simulated(stage, options):
            await _run_missions(stage, access.url, login.token, options.keep_going)
        seconds = monotonic() - began
    return DemoReport(stage.map_id, round(seconds, 2), [mission.close() for mission in stage.missions])


async def _own_cloud(stack: contextlib.AsyncExitStack) -> CloudAccess:
    cloud = await stack.enter_async_context(CloudProcess())
    return CloudAccess(cloud.ready.url, cloud.ready.admin_user, cloud.password)


def _waiting(console: Console | None) -> contextlib.AbstractContextManager[object]:
    """Show that something goes on until robots can be shown."""
    if console is None:
        return contextlib.nullcontext()
    return console.status("starting the cloud; the first start on a computer compiles the kernels for a minute")


async def introduce(rest: RestClient, stage: Stage, options: DemoOptions) -> None:
    """Tell the cloud of the map and the robots in it."""
    yaml, image = save_map(stage.grid, "map.pgm")
    await rest.upload_map(stage.map_id, yaml, image)
    for mission in stage.missions:
        start = mission.course.start
        robot = RobotFile(
            map=stage.map_id,
            initial_pose=(start.x, start.y, start.theta),
            cores=CORES,
            base_global_planner=options.planner,
            base_local_planner=options.controller,
        )
        await rest.put_robot(mission.robot, robot)


@contextlib.asynccontextmanager
async def _simulated(stage: Stage, options: DemoOptions) -> AsyncIterator[None]:
    """Let the world go on, and show it, meanwhile."""
    tasks = [asyncio.create_task(Simulator(stage.world).run())]
    if options.console is not None:
        tasks.append(asyncio.create_task(show(stage.missions, options.console)))
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _run_missions(stage: Stage, url: str, token: str, keep_going: bool) -> None:
    async with asyncio.TaskGroup() as group:
        tasks = [group.create_task(m.run(url, token, keep_going=keep_going)) for m in stage.missions]
        if keep_going:
            with _on_interrupt(tasks):
                await asyncio.wait(tasks)


@contextlib.contextmanager
def _on_interrupt(tasks: list[asyncio.Task[None]]) -> Iterator[None]:
    """End the tasks by Ctrl-C, and not the program: what they did is still told."""
    loop = asyncio.get_running_loop()
    loop.add_signal_handler(signal.SIGINT, lambda: [task.cancel() for task in tasks])
    try:
        yield
    finally:
        loop.remove_signal_handler(signal.SIGINT)
