"""The demo end to end: a cloud, a map, simulated robots with goals, and a scorer."""

import asyncio
import contextlib
import logging
import signal
from collections.abc import AsyncIterator, Callable, Iterator
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
from robots.demo.start_progress import free_port, tell_start
from robots.sim.courses import CoursePlanner
from robots.sim.robot import SimulatedRobotModel
from robots.sim.simulator import Simulator
from robots.sim.world import World

logger = logging.getLogger(__name__)

Tell = Callable[[str], None]
"""Shows a text."""

CORES = 0.5
"""Size of a robot's container [CPU cores]; it is idle between scans."""


@dataclass(frozen=True, slots=True)
class DemoOptions:
    """Options of the demo.

    Parameters
    ----------
    robots, goals : int
        Number of robots, and of goals per robot.
    seed : int
        Seed of the courses, of the world's noise, and of the generated warehouse.
    map_path : Path, optional
        YAML file of a map; by default a warehouse is generated.
    keep_going : bool
        Repeat the courses until interrupted.
    console : Console, optional
        Console for the progress display; none by default.
    planner, controller : str
        Move Base's global and local planner.
    cloud : CloudAccess, optional
        Running cloud to use; by default one is started.
    explorers : int
        Number of robots that explore, in the demo of mapping.
    people : int
        Number of people, in the demo of people.
    seconds : float
        Time that is scored, in the demo of people [s].
    on_robot : bool
        Whether detectors of people run on the robots, instead of in the cloud.
    sensor : str
        Sensor that detects people: ``camera`` or ``laser``.
    traffic : bool
        Whether the robots take part in the traffic of the map.
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
    explorers: int = 1
    people: int = 5
    seconds: float = 60.0
    on_robot: bool = True
    sensor: str = "camera"
    traffic: bool = False


@dataclass(frozen=True, slots=True)
class CloudAccess:
    """URL of a cloud, and the name and password of an administrator."""

    url: str
    admin: str
    password: str


@dataclass(frozen=True, slots=True)
class Stage:
    """Map, world and missions of a demo."""

    map_id: str
    grid: GridMap
    world: World
    missions: list[Mission]


def set_stage(options: DemoOptions) -> Stage:
    """Load or generate the map, choose the courses, and place the robots at their starts.

    Raises
    ------
    PPaaSError
        The map cannot be read, or is too small for this number of robots and goals.
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
    """Run the demo in the given cloud or in a new one; return its report.

    Raises
    ------
    PPaaSError
        The map or the options are invalid, or the cloud does not start or rejects the login.
    """
    async with contextlib.AsyncExitStack() as stack:
        with waiting(options.console) as tell:
            stage = await asyncio.to_thread(set_stage, options)
            access = options.cloud or await own_cloud(stack, tell)
        rest = RestClient(access.url)
        login = await rest.login(access.admin, access.password)
        await register(rest, stage, options)
        began = monotonic()
        async with _simulated(stage, options):
            await _run_missions(stage, access.url, login.token, options.keep_going)
        seconds = monotonic() - began
    return DemoReport(stage.map_id, round(seconds, 2), [mission.close() for mission in stage.missions])


async def own_cloud(stack: contextlib.AsyncExitStack, tell: Tell) -> CloudAccess:
    """Start a cloud, which ends with the stack; tell what it does meanwhile."""
    port = free_port()
    telling = asyncio.create_task(tell_start(f"http://127.0.0.1:{port}", tell))
    try:
        cloud = await stack.enter_async_context(CloudProcess(arguments=("--port", str(port))))
    finally:
        telling.cancel()
        await asyncio.gather(telling, return_exceptions=True)
    return CloudAccess(cloud.ready.url, cloud.ready.admin_user, cloud.password)


@contextlib.contextmanager
def waiting(console: Console | None) -> Iterator[Tell]:
    """Show a status line until the robots are running; enter with a function that changes it.

    Without a console, its texts are logged.
    """
    if console is None:
        yield lambda text: logger.warning("%s", text)
        return
    with console.status("starting the cloud") as status:
        yield status.update


async def register(rest: RestClient, stage: Stage, options: DemoOptions) -> None:
    """Publish the map and register the robots."""
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
            traffic=options.traffic,
        )
        await rest.put_robot(mission.robot, robot)


@contextlib.asynccontextmanager
async def _simulated(stage: Stage, options: DemoOptions) -> AsyncIterator[None]:
    """Run the simulation and the progress display during the block."""
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
            with on_interrupt(tasks):
                await asyncio.wait(tasks)


@contextlib.contextmanager
def on_interrupt(tasks: list[asyncio.Task[None]]) -> Iterator[None]:
    """Make Ctrl-C cancel the tasks instead of the program, so the report is still printed."""
    loop = asyncio.get_running_loop()
    loop.add_signal_handler(signal.SIGINT, lambda: [task.cancel() for task in tasks])
    try:
        yield
    finally:
        loop.remove_signal_handler(signal.SIGINT)
