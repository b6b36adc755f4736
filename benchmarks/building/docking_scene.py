"""One robot, the node that docks it and simulated docks, in one process and on a clock that is stepped."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ppaas.clock import ManualClock
from ppaas.clone.driving import outline_of
from ppaas.costmap.map_layers import MapLayers, empty_layers
from ppaas.docking.parameters import DockingParameters
from ppaas.docking.targets import DockTargets
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Twist
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult
from ppaas.messages.nav2_servers import DockRobotActionGoal, DockRobotActionResult, DockRobotGoal
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.base import Payload
from ppaas.nodes.docking_server.node import DockingServerNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.nav2_actions import DOCK_ROBOT
from ppaas.robot_model.known_models import robot_model
from ppaas.transforms.planar import transform_message
from ppaas.zones.shapes import Point
from ppaas.zones.zone import Dock, Zone, ZoneSet
from robots.sim.bodies.furniture import Furniture
from robots.sim.docks.battery import SimulatedBattery
from robots.sim.docks.charger import Charger
from robots.sim.laser import LaserModel
from robots.sim.odometry import OdometryNoise
from robots.sim.robot import SimulatedRobotModel, TurtlebotModel
from robots.sim.world import World

SIDE = 8.0
"""Length of the room [m]."""

SCAN_PERIOD, ODOM_PERIOD, BATTERY_PERIOD = 0.1, 0.04, 0.5
"""Periods of the robot's messages [s]."""


@dataclass(frozen=True, slots=True)
class DockingNoise:
    """Errors of sensors, of localization and of Move Base, as standard deviations [m, rad, A].

    ``lost`` is the part of the messages of the battery that do not come.
    """

    scan: float = 0.015
    odometry: float = 2.0
    slip: float = 0.05
    localization: tuple[float, float] = (0.05, 0.05)
    staging: tuple[float, float] = (0.06, 0.08)
    current: float = 0.5
    lost: float = 0.2


@dataclass(slots=True)
class DockingOutcome:
    """End of a goal, with the time that it took [s], the battery's true current [A], and whether contacts touch."""

    status: Status
    text: str
    retries: int
    seconds: float
    current: float
    touches: bool


def room() -> GridMap:
    """Return an empty room with walls."""
    cells = round(SIDE / 0.05)
    data = np.full((cells, cells), FREE, np.int8)
    data[:2] = data[-2:] = OCCUPIED
    data[:, :2] = data[:, -2:] = OCCUPIED
    return GridMap(data, GridInfo(0.05, cells, cells))


class DockingScene:
    """A robot with a battery before some chargers.

    Parameters
    ----------
    chargers : dict of str to Charger
        By the names of their docks.
    mapped : dict of str to Pose2D
        Where the map has the docks; one without a charger does not charge.
    seed : int
    parameters : DockingParameters, optional
    noise : DockingNoise, optional
    furniture : sequence of Furniture
        What else stands in the room.
    dock_type : str
        Type of all docks.
    """

    def __init__(
        self, chargers: dict[str, Charger], mapped: dict[str, Pose2D], seed: int, *,
        parameters: DockingParameters | None = None, noise: DockingNoise | None = None,
        furniture: Sequence[Furniture] = (), dock_type: str = "",
    ) -> None:  # fmt: skip
        self.noise, self._dock_type = noise or DockingNoise(), dock_type
        self._rng = np.random.default_rng((seed, 7))
        self._world = World(room(), seed)
        self._world.epoch = 1000.0
        base = TurtlebotModel(slip=self.noise.slip)
        model = SimulatedRobotModel(base, LaserModel(sigma=self.noise.scan), OdometryNoise(drift=self.noise.odometry))
        for piece in (*(charger.body() for charger in chargers.values()), *furniture):
            self._world.add_furniture(piece)
        x, y, theta = (self._rng.uniform(2.0, SIDE - 2.0) for _ in range(3))
        self.robot = self._world.add_robot(Pose2D(x, y, theta), model)
        self.chargers = chargers
        self.battery = SimulatedBattery(tuple(chargers.values()), self._rng, charge=0.5)
        self._wrong = Pose2D(0.0, 0.0)
        self.clock = ManualClock(1000.0)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        self.add_node(parameters or DockingParameters(), mapped)
        self.ended: DockRobotActionResult | None = None
        self.graph.tap("cmd_vel", self._drive)
        self.graph.tap("move_base/goal", self._stage)
        self.graph.tap(DOCK_ROBOT.result.name, self._end)
        self._staged: GoalID | None = None

    def add_node(self, parameters: DockingParameters, mapped: dict[str, Pose2D]) -> None:
        """Start the node, with docks where the map has them."""
        body, outline = robot_model("turtlebot2"), outline_of(robot_model("turtlebot2"))
        docks = [
            (at, Dock(name=name, yaw=at.theta, dock_type=self._dock_type, charges=name in self.chargers))
            for name, at in mapped.items()
        ]
        zones = ZoneSet([Zone(Point([at.x, at.y]), dock) for at, dock in docks])
        layers: MapLayers = replace(empty_layers(1.0), zones=zones)
        targets = DockTargets(parameters, outline)
        self.node = self.graph.add(
            lambda context: DockingServerNode(
                context, parameters, targets, outline, braking=body.limits.acc_lim_x, layers=layers
            )
        )

    # -- what the node does --------------------------------------------------------------------------------------------

    def _drive(self, _: str, message: Payload) -> None:
        assert isinstance(message, Twist)
        self.robot.command(message)

    def _stage(self, _: str, message: Payload) -> None:
        """Drive to a pose as Move Base does: nearly there, as far as the robot knows where it is."""
        assert isinstance(message, MoveBaseActionGoal)
        far, turn = self.noise.staging
        off = self._drawn(far, turn)
        self.localize()
        self.robot.base.carry_to(message.goal.target_pose.pose.planar() @ self._wrong.inverse() @ off)
        self.robot.command(Twist())
        self._staged = message.goal_id

    def localize(self) -> None:
        """Draw another error of localization."""
        far, turn = self.noise.localization
        self._wrong = self._drawn(far, turn)

    def _drawn(self, far: float, turn: float) -> Pose2D:
        x, y, theta = self._rng.normal(0.0, (far, far, turn)).tolist()
        return Pose2D(x, y, theta)

    def _end(self, _: str, message: Payload) -> None:
        assert isinstance(message, DockRobotActionResult)
        self.ended = message

    # -- time ----------------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Simulate one step, and send what the robot measures."""
        world, before = self._world, self._world.time()
        world.step()
        self.clock.advance(world.dt)
        now = world.time()
        wheels = self.robot.base.wheels
        self.battery.step(self.robot.base.pose, wheels.linear, world.dt)
        if _is_due(before, now, ODOM_PERIOD):
            self._send_frames()
        if _is_due(before, now, SCAN_PERIOD):
            self.graph.inject("scan", self.robot.scan())
        if _is_due(before, now, BATTERY_PERIOD) and self._rng.random() >= self.noise.lost:
            state = self.battery.message(world.stamp())
            self.graph.inject("battery_state", state)
        if self._staged is not None:
            goal_id, self._staged = self._staged, None
            self._send_frames()
            status = GoalStatus(goal_id, Status.SUCCEEDED, "Goal reached.")
            self.graph.inject("move_base/result", MoveBaseActionResult(Header(), status))
        self.graph.run_due()

    def _send_frames(self) -> None:
        odometry = self.robot.odometry()
        odom, stamp = odometry.pose.pose.planar(), odometry.header.stamp
        in_map = self.robot.base.pose @ self._wrong
        frames = [
            transform_message("odom", "base_link", odom, stamp),
            transform_message("map", "odom", in_map @ odom.inverse(), stamp),
        ]
        self.graph.inject("tf", TFMessage(frames))

    def dock(self, name: str, longest: float = 240.0) -> DockingOutcome:
        """Send a goal, and simulate until it ends."""
        for _ in range(10):
            self.step()
        begin = self._world.time()
        goal = DockRobotActionGoal(goal_id=GoalID(Time.of(self.clock()), "bench"), goal=DockRobotGoal(dock_id=name))
        self.graph.inject(DOCK_ROBOT.goal.name, goal)
        while self.ended is None and self._world.time() - begin < longest:
            self.step()
        at = self.robot.base.pose
        touches = any(charger.touches(at) for charger in self.chargers.values())
        if self.ended is None:
            return DockingOutcome(Status.LOST, "no result", 0, longest, self.battery.flow, touches)
        end = self.ended
        return DockingOutcome(
            Status(end.status.status), end.status.text, end.result.num_retries, self._world.time() - begin,
            self.battery.flow, touches,
        )  # fmt: skip


def _is_due(before: float, now: float, period: float) -> bool:
    return math.floor(now / period + 1e-9) > math.floor(before / period + 1e-9)
