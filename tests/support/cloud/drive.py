"""Simulated Turtlebot connected over a real socket, with an operator that sends goals."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from functools import partial

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovarianceStamped, Twist
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from robots.client.connection import ConnectionOptions
from robots.client.robot_client import RobotClient
from robots.demo.scorer import Scorer
from robots.sim.driver import Driver
from robots.sim.floors.building import SimulatedBuilding
from robots.sim.simulator import Simulator
from robots.sim.world import World


@dataclass
class Drive:
    """A connected robot with its operator, its scorer, and the messages received."""

    operator: RobotClient
    robot: RobotClient
    world: World | SimulatedBuilding
    scorer: Scorer
    commands: list[tuple[float, Twist]] = field(default_factory=list)
    poses: list[PoseWithCovarianceStamped] = field(default_factory=list)
    status: GoalStatusArray = field(default_factory=GoalStatusArray)
    results: "asyncio.Queue[MoveBaseActionResult]" = field(default_factory=asyncio.Queue)

    async def send(self, goal: Pose2D, goal_id: str = "") -> None:
        """Send a goal through Move Base's action."""
        target = PoseStamped(Header(frame_id="map"), Pose.of(goal))
        await self.operator.publish("move_base/goal", MoveBaseActionGoal(MoveBaseGoal(target), GoalID(id=goal_id)))

    async def result(self, timeout: float = 90.0) -> MoveBaseActionResult:
        """Wait for the next result."""
        try:
            async with asyncio.timeout(timeout):
                return await self.results.get()
        except TimeoutError:
            raise AssertionError(f"no result within {timeout:g} s: {self.situation()}") from None

    def situation(self) -> str:
        """Return the robot's state as text, for the messages of failed tests."""
        truth, believed = self.world.robots[0].base.pose, self.estimate() if self.poses else None
        commands = [(twist.linear.x, twist.angular.z) for _, twist in self.commands[-3:]]
        status = [(s.goal_id.id, s.status, s.text) for s in self.status.status_list]
        touched = self.scorer.collisions(0)
        return f"{truth=}, {believed=}, {status=}, last {commands=}, {touched=}"

    async def go(self, goal: Pose2D, timeout: float = 90.0) -> float:
        """Drive to a goal; return the true distance to it at the end [m]."""
        await self.send(goal)
        result = await self.result(timeout)
        assert result.status.status == Status.SUCCEEDED, result.status.text
        return self.scorer.error(0, goal)

    def estimate(self) -> Pose2D:
        """Return the last pose estimate of the cloud."""
        return self.poses[-1].pose.pose.planar()


@asynccontextmanager
async def driving(
    url: str,
    token: str,
    robot_id: str,
    grid: GridMap | None,
    pose: Pose2D,
    *,
    seed: int = 0,
    link: ConnectionOptions | None = None,
    client: type[RobotClient] = RobotClient,
    shared: World | SimulatedBuilding | None = None,
) -> AsyncIterator[Drive]:
    """Simulate one Turtlebot, on a grid or in a shared world that others simulate, and connect it to a cloud."""
    if shared is None:
        assert grid is not None, "a robot needs a map or a shared world"
    world = World(grid, seed) if shared is None else shared
    simulated = world.add_robot(pose)
    loop = asyncio.get_running_loop()
    async with (
        client(url, robot=robot_id, token=token, link=link) as robot,
        RobotClient(url, robot=robot_id, token=token, role="operator", link=link) as operator,
    ):
        drive = Drive(operator, robot, world, Scorer(world))
        tasks = [asyncio.create_task(Driver(simulated, robot).run())]
        if shared is None:
            tasks.append(asyncio.create_task(Simulator(world).run()))
        await operator.subscribe("move_base/result", MoveBaseActionResult, drive.results.put_nowait)
        await operator.subscribe("move_base/status", GoalStatusArray, partial(setattr, drive, "status"))
        await operator.subscribe("amcl_pose", PoseWithCovarianceStamped, drive.poses.append)
        await robot.subscribe("cmd_vel", Twist, lambda twist: drive.commands.append((loop.time(), twist)))
        try:
            yield drive
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
