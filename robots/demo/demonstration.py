"""The demo of driving: a map, simulated robots with goals, a scorer, and the progress on a terminal."""

import asyncio
import contextlib
import signal
from collections.abc import AsyncIterator, Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial

from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table

from ppaas.clock import monotonic
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from robots.client.robot_file import RobotFile
from robots.demo.mission import Mission
from robots.demo.options import CORES, CloudAccess, DemoOptions, no_lines
from robots.demo.report import DemoReport
from robots.demo.scorer import Scorer
from robots.sim.courses import CoursePlanner, GoalRules
from robots.sim.robot import SimulatedRobotModel
from robots.sim.simulator import Simulator
from robots.sim.world import World

PERIOD = 0.25
"""Time between two updates of the display [s]."""


def progress_table(missions: list[Mission]) -> Table:
    """Return a table with a row per robot: its goal, the distance to it, and its contacts."""
    table = Table(title="PPaaS demo", title_justify="left")
    for heading in ("robot", "goal", "to go (m)", "travelled (m)", "contacts", "state"):
        table.add_column(heading, justify="left" if heading in ("robot", "state") else "right")
    for mission in missions:
        scorer, progress = Scorer(mission.world), mission.progress
        left = f"{scorer.error(mission.index, progress.target):.2f}" if progress.target else "-"
        table.add_row(
            mission.robot,
            f"{progress.goal}/{progress.goals}" if progress.goal <= progress.goals else str(progress.goal),
            left,
            f"{scorer.distance(mission.index):.1f}",
            str(scorer.collisions(mission.index)),
            escape(progress.state),
        )
    return table


async def show(table: Callable[[], Table], console: Console) -> None:
    """Show a table on the terminal, and keep it up to date until cancelled."""
    with Live(table(), console=console, auto_refresh=False) as live:
        try:
            while True:
                live.update(table(), refresh=True)
                await asyncio.sleep(PERIOD)
        finally:
            live.update(table(), refresh=True)


RULES = GoalRules(shortest=0.2, preferred=0.25)
"""Goals near enough that a robot reaches two in half a minute, in the warehouse."""


@dataclass(frozen=True, slots=True)
class DemoStage:
    """Map, world and missions of a demo."""

    map_id: str
    grid: GridMap
    world: World
    missions: list[Mission]


def set_stage(options: DemoOptions) -> DemoStage:
    """Take or generate the map, choose the courses, and place the robots at their starts.

    Raises
    ------
    PPaaSError
        The map is too small for this number of robots and goals.
    """
    map_id, grid = options.map or ("warehouse", warehouse(options.seed))
    courses = CoursePlanner(grid, options.seed, RULES).choose(options.robots, options.goals)
    world = World(grid, options.seed)
    write = options.write if options.console is None else no_lines
    missions = []
    for index, course in enumerate(courses):
        world.add_robot(course.start, SimulatedRobotModel())
        missions.append(Mission(world, index, f"turtlebot-{index + 1}", course, write))
    return DemoStage(map_id, grid, world, missions)


async def demonstrate(options: DemoOptions, cloud: CloudAccess) -> DemoReport:
    """Run the demo in a cloud; return its report.

    Raises
    ------
    PPaaSError
        The map or the options are invalid, or the cloud rejects the login.
    """
    stage = await asyncio.to_thread(set_stage, options)
    rest = RestClient(cloud.url)
    login = await rest.login(cloud.admin, cloud.password)
    await register(rest, stage, options)
    began = monotonic()
    async with _simulated(stage, options):
        await run_missions(stage.missions, cloud.url, login.token, options.keep_going)
    seconds = monotonic() - began
    return DemoReport(stage.map_id, round(seconds, 2), [mission.close() for mission in stage.missions])


async def register(rest: RestClient, stage: DemoStage, options: DemoOptions) -> None:
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
async def _simulated(stage: DemoStage, options: DemoOptions) -> AsyncIterator[None]:
    tasks = [asyncio.create_task(Simulator(stage.world).run())]
    if options.console is not None:
        tasks.append(asyncio.create_task(show(partial(progress_table, stage.missions), options.console)))
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def run_missions(missions: Iterable[Mission], url: str, token: str, keep_going: bool) -> None:
    """Drive all missions at once, with ``keep_going`` until Ctrl-C."""
    async with asyncio.TaskGroup() as group:
        tasks = [group.create_task(m.run(url, token, keep_going=keep_going)) for m in missions]
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
