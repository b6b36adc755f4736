"""Driving by hand: the time from a command of an operator to the velocity at the robot, and to a stop."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Awaitable

import numpy as np
from rich.progress import Progress
from websockets.asyncio.client import connect

from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.figures import Figure, median_of
from benchmarks.service.plan_requests import echo
from ppaas.clock import monotonic
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped, Twist
from robots.client.robot_client import RobotClient
from robots.client.teleop import driving_by_hand
from robots.sim.driver import Driver
from robots.sim.simulator import Simulator
from robots.sim.world import World

PART = "teleop"
MAP, ROBOT = "bench-teleop", "teleop"
SAMPLES, QUICK = 200, 40
WARM = 10
"""Number of samples that are not counted."""

COMMAND_LIMIT, STOP_LIMIT = 30.0, 50.0
"""Largest acceptable medians [ms]."""

PAUSE = 0.037
"""Time between two samples [s], so that they meet the control cycle of the clone at all its phases."""

SLOWEST, STEP = 0.2, 0.001
"""First turn that is commanded, and difference to the next, by which a command is known [rad/s]."""

PATIENCE = 10.0
"""Time limit of a sample [s]."""

FRAME = 250
"""Size of an echoed frame, about the size of a command [bytes]."""


async def measure(target: CloudUnderTest, progress: Progress, quick: bool) -> list[Figure]:
    """Drive a simulated robot by hand; measure commands, stops, and an echo."""
    count = QUICK if quick else SAMPLES
    arrivals = TurnArrivals()
    async with robot_in_hall(target, ROBOT) as (client, operator), driving_by_hand(operator) as hand:
        await client.subscribe("cmd_vel", Twist, arrivals.take)
        commands, stops = [], []
        for number in progress.track(range(WARM + count), description="teleop"):
            turn = SLOWEST + STEP * number
            took = await arrivals.after(hand.drive(0.0, turn), turn)
            stopped = await arrivals.after(hand.let_go(), 0.0)
            if number >= WARM:
                commands.append(took)
                stops.append(stopped)
            await asyncio.sleep(PAUSE)
    echoed = await _echoed(count)
    note = "from the operator's socket to the robot's, while scans and odometry come"
    return [
        median_of(PART, "command to cmd_vel", commands, limit=COMMAND_LIMIT, note=note),
        median_of(PART, "letting go to cmd_vel 0", stops, limit=STOP_LIMIT, note=note),
        median_of(PART, "echo of a frame", echoed, yardstick=True, note=f"{FRAME} bytes, websockets"),
    ]


class TurnArrivals:
    """Velocities that arrive at the robot."""

    def __init__(self) -> None:
        self._wanted = 0.0
        self._arrived = asyncio.Event()

    def take(self, twist: Twist) -> None:
        """Note a velocity."""
        if twist.angular.z == self._wanted:
            self._arrived.set()

    async def after(self, order: Awaitable[None], turn: float) -> float:
        """Give an order; return the time until the turn that it causes arrives [s]."""
        self._wanted = turn
        self._arrived.clear()
        began = monotonic()
        await order
        async with asyncio.timeout(PATIENCE):
            await self._arrived.wait()
        return monotonic() - began


@contextlib.asynccontextmanager
async def robot_in_hall(target: CloudUnderTest, name: str) -> AsyncIterator[tuple[RobotClient, RobotClient]]:
    """Connect a simulated robot, and an operator; return the clients of both, once the robot is localized."""
    grid = _hall()
    await target.publish(MAP, grid)
    world = World(grid)
    start = Pose2D(2.0, 2.0, 0.0)
    await target.register(name, MAP, (start.x, start.y, start.theta))
    robot = world.add_robot(start)
    async with (
        RobotClient(target.url, robot=name, token=target.token) as client,
        RobotClient(target.url, robot=name, token=target.token, role="operator") as operator,
    ):
        tasks = [asyncio.create_task(work) for work in (Driver(robot, client).run(), Simulator(world).run())]
        try:
            posed = await operator.subscribe("amcl_pose", PoseWithCovarianceStamped, queue_size=1)
            await anext(posed)
            yield client, operator
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)


def _hall() -> GridMap:
    """Return a hall of 6 × 4 m without furniture."""
    cells = np.full((80, 120), FREE, np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    return GridMap(cells, GridInfo(0.05, 120, 80))


async def _echoed(count: int) -> list[float]:
    samples = []
    async with echo("websockets", FRAME) as server, connect(f"ws://{server.address}") as plain:
        for _ in range(WARM + count):
            began = monotonic()
            await plain.send("x" * FRAME)
            await plain.recv()
            samples.append(monotonic() - began)
    return samples[WARM:]
