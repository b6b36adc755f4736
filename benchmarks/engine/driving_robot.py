"""Driving robot, and an observer that records the times of its commands."""

import asyncio
import contextlib
from collections.abc import AsyncIterator

from benchmarks.engine.site import EngineSite
from benchmarks.harness.roaming_robot import roaming_robot
from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Twist
from robots.client.robot_client import RobotClient
from robots.sim.courses import CoursePlanner
from robots.sim.simulator import Simulator
from robots.sim.world import World

PATIENCE = 30.0
"""Time within which commands must arrive [s]."""
MAP = "bench-driven"
"""Id of the map."""
UNDER_WAY = 10
"""Number of commands before a fault is injected."""


def grid_to_drive_on() -> GridMap:
    """Return the map of driving robots."""
    return office(seed=1, width=12.0, height=10.0)


class CommandObserver:
    """Observes a robot's commands on a second connection.

    Attributes
    ----------
    commands : list of float
        Arrival time of each command [monotonic s].
    """

    def __init__(self) -> None:
        self.commands: list[float] = []
        self._heard = asyncio.Event()

    def heard(self, _: Twist) -> None:
        """Record a command."""
        self.commands.append(monotonic())
        self._heard.set()

    async def hears(self, count: int) -> None:
        """Wait for ``count`` more commands.

        Raises
        ------
        Unavailable
            They do not arrive within the time limit.
        """
        enough = len(self.commands) + count
        try:
            async with asyncio.timeout(PATIENCE):
                while len(self.commands) < enough:
                    self._heard.clear()
                    await self._heard.wait()
        except TimeoutError as error:
            raise Unavailable(f"a driving robot received no command for {PATIENCE:g} s") from error


@contextlib.asynccontextmanager
async def driven(site: EngineSite, robot: str, grid: GridMap) -> AsyncIterator[CommandObserver]:
    """Make a robot drive on a published map; yield its observer once the robot is under way."""
    url, token = site.target.url, site.target.token
    course = CoursePlanner(grid, 1).choose(1, 3)[0]
    world = World(grid, 1)
    await site.target.register(robot, MAP, course.start)
    body = world.add_robot(course.start)
    running = asyncio.create_task(Simulator(world).run())
    try:
        async with (
            roaming_robot(url, token, robot, body, course),
            RobotClient(url, robot=robot, token=token, role="operator", hold=False) as client,
        ):
            observer = CommandObserver()
            await client.subscribe("cmd_vel", Twist, observer.heard)
            await observer.hears(UNDER_WAY)
            yield observer
    finally:
        running.cancel()
