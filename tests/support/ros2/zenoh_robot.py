"""A simulated robot with ROS 2 over Zenoh, and another node beside it, for journeys."""

import asyncio
import json
import socket
import uuid
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ppaas.clock import monotonic
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages import encode
from ppaas.messages.geometry_msgs import Pose
from robots.sim.simulator import Simulator
from robots.sim.world import World
from tests.support.ros2.turtlebot import Turtlebot
from tests.support.ros2.zenoh_peer import Peer


def free_endpoint() -> str:
    """Return an endpoint of Zenoh at a free port."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        return f"tcp/127.0.0.1:{listening.getsockname()[1]}"


@dataclass
class DrivenRobot:
    """A robot that drives, and another node of ROS 2 beside it."""

    world: World
    robot: Turtlebot
    operator: Peer

    @property
    def pose(self) -> Pose2D:
        """True pose of the robot."""
        return self.world.robots[0].base.pose

    async def act(self, action: str, kind: str, goal: dict[str, Any]) -> bytes:
        """Send a goal; return its id."""
        goal_id = uuid.uuid4().bytes
        request = {"goal_id": {"uuid": goal_id}, "goal": goal}
        sent = await asyncio.to_thread(self.operator.call, f"{action}/_action/send_goal", f"{kind}_SendGoal", request)
        assert sent["accepted"]
        return goal_id

    async def result(self, action: str, kind: str, goal_id: bytes) -> dict[str, Any]:
        """Wait for the result of a goal."""
        request = {"goal_id": {"uuid": goal_id}}
        return await asyncio.to_thread(
            self.operator.call, f"{action}/_action/get_result", f"{kind}_GetResult", request, 120.0
        )

    async def send_goal(self, goal: Pose2D) -> None:
        """Send a goal as RViz does; again until the robot drives, for its clone may not be localized yet."""
        publish = self.operator.publisher("goal_pose", "geometry_msgs/msg/PoseStamped")
        message = {"header": {"frame_id": "map"}, "pose": json.loads(encode(Pose.of(goal)))}
        for _ in range(10):
            await asyncio.sleep(0.5)
            publish(message)
            try:
                await self.drives(timeout=3.0)
            except AssertionError:
                continue
            return
        raise AssertionError("the robot does not drive to its goal")

    async def drives(self, timeout: float = 20.0) -> None:
        """Wait until the robot has moved by 0.1 m."""
        begin, deadline = self.pose, monotonic() + timeout
        while self.pose.distance_to(begin) < 0.1:
            assert monotonic() < deadline, f"the robot stands at {begin}"
            await asyncio.sleep(0.05)

    async def stands(self, timeout: float = 2.0) -> None:
        """Wait until the robot has not moved for 0.3 s."""
        deadline, begin = monotonic() + timeout, self.pose
        while True:
            await asyncio.sleep(0.3)
            if self.pose.distance_to(begin) < 0.005:
                return
            assert monotonic() < deadline, "the robot does not stop"
            begin = self.pose

    async def arrives(self, goal: Pose2D, timeout: float = 60.0) -> None:
        """Wait until the robot stands within 0.3 m of its goal."""
        deadline = monotonic() + timeout
        while self.pose.distance_to(goal) > 0.3:
            assert monotonic() < deadline, f"the robot is at {self.pose}, not at {goal}"
            await asyncio.sleep(0.1)


@asynccontextmanager
async def zenoh_robot(
    endpoint: str, grid: GridMap, start: Pose2D, namespace: str = "", *, authority: Path | None = None
) -> AsyncIterator[DrivenRobot]:
    """Run a robot in a namespace, and another node; ``authority`` is that of a router with TLS."""
    world = World(grid, 0)
    simulated = world.add_robot(start)
    # In threads, for a forwarder between robot and bridge may be on this event loop.
    node, operator = [
        await asyncio.to_thread(Peer, endpoint, name, namespace=namespace, authority=authority)
        for name in ("turtlebot", "operator")
    ]
    robot = Turtlebot(simulated, node)
    tasks = [asyncio.create_task(Simulator(world).run()), asyncio.create_task(robot.run())]
    try:
        yield DrivenRobot(world, robot, operator)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await asyncio.to_thread(node.close)
        await asyncio.to_thread(operator.close)
