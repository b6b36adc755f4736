"""A robot that drives, and whoever looks on notes when it is commanded."""

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
MAP = "bench-driven"
UNDER_WAY = 10
"""Commands that a robot has had before anything is done to it."""


def grid_to_drive_on() -> GridMap:
    """Return the map of the robots that drive."""
    return office(seed=1, width=12.0, height=10.0)


class Looker:
    """Hears a robot's commands, beside the robot.

    Attributes
    ----------
    commands : list of float
        When each came [s].
    """

    def __init__(self) -> None:
        self.commands: list[float] = []
        self._heard = asyncio.Event()

    def heard(self, _: Twist) -> None:
        """Note a command."""
        self.commands.append(monotonic())
        self._heard.set()

    async def hears(self, count: int) -> None:
        """Wait for more commands.

        Raises
        ------
        Unavailable
            They do not come.
        """
        enough = len(self.commands) + count
        try:
            async with asyncio.timeout(PATIENCE):
                while len(self.commands) < enough:
                    self._heard.clear()
                    await self._heard.wait()
        except TimeoutError as error:
            raise Unavailable(f"a robot that drives was not commanded for {PATIENCE:g} s") from error


@contextlib.asynccontextmanager
async def driven(site: EngineSite, robot: str, grid: GridMap) -> AsyncIterator[Looker]:
    """Have a robot drive on a map that is published; it is under way."""
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
            looker = Looker()
            await client.subscribe("cmd_vel", Twist, looker.heard)
            await looker.hears(UNDER_WAY)
            yield looker
    finally:
        running.cancel()
