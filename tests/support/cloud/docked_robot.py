"""Simulated robot with a battery in a world with chargers, connected to a cloud over a real socket."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import GoalStatus, Status
from ppaas.messages.nav2_servers import (
    DockRobotFeedback,
    DockRobotGoal,
    DockRobotResult,
    UndockRobotFeedback,
    UndockRobotGoal,
    UndockRobotResult,
)
from ppaas.nodes.nav2_actions import DOCK_ROBOT, UNDOCK_ROBOT
from ppaas.zones.zone import ZoneSet
from robots.client.action_client import ActionClient
from robots.client.move_base import MoveBaseClient
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from robots.sim.docks.fitting import DockingParts, DocksOfWorld, fit_docks
from robots.sim.driver import Driver
from robots.sim.robot import SimulatedRobot
from robots.sim.simulator import Simulator
from robots.sim.world import World


@dataclass
class DockedScene:
    """A connected robot, its operator, and what is true of it."""

    operator: RobotClient
    robot: SimulatedRobot
    docks: DocksOfWorld
    parts: DockingParts
    feedback: list[DockRobotFeedback] = field(default_factory=list)

    async def dock(self, name: str) -> tuple[GoalStatus, DockRobotResult]:
        """Dock, and return the end."""
        client: ActionClient[DockRobotFeedback, DockRobotResult] = ActionClient(
            self.operator, DOCK_ROBOT, lacking="no node", on_feedback=self.feedback.append
        )
        status, result = await asyncio.wait_for(client.run(DockRobotGoal(dock_id=name)), 150.0)
        assert result is not None, status
        return status, result

    async def undock(self) -> tuple[GoalStatus, UndockRobotResult]:
        """Undock, and return the end."""
        client: ActionClient[UndockRobotFeedback, UndockRobotResult] = ActionClient(
            self.operator, UNDOCK_ROBOT, lacking="no node"
        )
        status, result = await asyncio.wait_for(client.run(UndockRobotGoal()), 60.0)
        assert result is not None, status
        return status, result

    async def drive(self, target: Pose2D) -> None:
        """Drive to a pose."""
        outcome = await (await MoveBaseClient(self.operator).start()).go(target)
        assert outcome.status is Status.SUCCEEDED, outcome


@asynccontextmanager
async def docked_scene(
    url: str, token: str, robot_id: str, grid: GridMap, zones: ZoneSet, file: RobotFile
) -> AsyncIterator[DockedScene]:
    """Simulate a robot in a world with a charger or a shelf at each dock, and connect it to a cloud."""
    world = World(grid)
    docks = fit_docks(world, zones, file.parameters)
    simulated = world.add_robot(file.pose)
    parts = docks.parts_of(simulated)
    async with (
        RobotClient(url, robot=robot_id, token=token) as robot,
        RobotClient(url, robot=robot_id, token=token, role="operator") as operator,
    ):
        simulator = Simulator(world, after_step=parts.after_step)
        tasks = [
            asyncio.create_task(Driver(simulated, robot, battery=parts.battery, lift=parts.lift).run()),
            asyncio.create_task(simulator.run()),
        ]
        try:
            yield DockedScene(operator, simulated, docks, parts)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
