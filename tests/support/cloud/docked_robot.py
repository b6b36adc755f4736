"""Simulated robot with a battery in a world with chargers, connected to a cloud over a real socket."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from functools import partial

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import GoalStatus
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
from robots.client.robot_client import RobotClient
from robots.sim.docks.charger import Charger
from robots.sim.docks.fitting import RobotBattery, fit_chargers
from robots.sim.driver import Driver
from robots.sim.robot import SimulatedRobot
from robots.sim.simulator import Simulator
from robots.sim.world import World


@dataclass
class DockedScene:
    """A connected robot, its operator, and what is true of it."""

    operator: RobotClient
    robot: SimulatedRobot
    battery: RobotBattery
    chargers: tuple[Charger, ...]
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


@asynccontextmanager
async def docked_scene(
    url: str,
    token: str,
    robot_id: str,
    grid: GridMap,
    pose: Pose2D,
    docks: ZoneSet | tuple[Charger, ...],
    *,
    charge: float = 0.8,
) -> AsyncIterator[DockedScene]:
    """Simulate a robot in a world with a charger at each dock, or with these chargers, and connect it to a cloud.

    With more charge than 70 %, the cloud does not send it to a charger by itself.
    """
    world = World(grid)
    chargers = fit_chargers(world, docks) if isinstance(docks, ZoneSet) else docks
    for charger in () if isinstance(docks, ZoneSet) else docks:
        world.add_furniture(charger.body())
    simulated = world.add_robot(pose)
    battery = RobotBattery(simulated, chargers, charge=charge)
    async with (
        RobotClient(url, robot=robot_id, token=token) as robot,
        RobotClient(url, robot=robot_id, token=token, role="operator") as operator,
    ):
        simulator = Simulator(world, after_step=partial(battery.after_step, world.dt))
        tasks = [
            asyncio.create_task(Driver(simulated, robot, battery=battery).run()),
            asyncio.create_task(simulator.run()),
        ]
        try:
            yield DockedScene(operator, simulated, battery, chargers)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
