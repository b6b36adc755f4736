"""A clone and a simulated robot in a closed loop, on a manual clock."""

from collections import deque
from collections.abc import Mapping
from typing import Protocol

from ppaas.clock import ManualClock
from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovarianceStamped, Twist
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.base import Payload
from ppaas.nodes.graph import Graph
from ppaas.nodes.jobs import Worker, run_inline
from ppaas.planners.base import PlanResult
from tests.support.world.planar_world import error_of

PERIOD = 0.05


class RobotWorld(Protocol):
    """A world with one robot in it."""

    grid: GridMap

    @property
    def pose(self) -> Pose2D:
        """True pose of the robot in the frame ``map``."""
        ...

    def move(self, linear: float, angular: float, seconds: float) -> None:
        """Drive the robot for a time [s]."""
        ...

    def clearance(self) -> float:
        """Return the distance from the robot's centre to the nearest wall [m], up to 1 m."""
        ...

    def odometry(self, stamp: float) -> Odometry:
        """Return the odometry as the robot sends it."""
        ...

    def scan(self, stamp: float) -> LaserScan:
        """Return the scan as the robot sends it."""
        ...


class ClosedLoop:
    """A clone that drives a world's robot. ``masks`` are those of `build_layers`; with ``maps`` it makes a new map.

    Odometry comes at 20 Hz, and a scan with every second odometry, or as ``scan_every`` says. The clock of the cloud is
    ``cloud_ahead`` seconds ahead of that of the robot. Messages of sensors take ``uplink`` periods to the clone, and
    commands ``downlink`` periods to the robot.
    """

    def __init__(
        self, world: RobotWorld, *, worker: Worker = run_inline, start: float = 1000.0,
        masks: Mapping[str, GridMap] | None = None, maps: bool = False, **clone: object,
    ) -> None:  # fmt: skip
        self.world = world
        self.clock = ManualClock(start)
        self.cloud_ahead = 0.0
        self.graph = Graph(worker, self.clock, lambda: self.clock() + self.cloud_ahead)
        self.layers = build_layers(world.grid, **(masks or {}))
        self.command = Twist()
        self.commands: list[Twist] = []
        self.results: list[MoveBaseActionResult] = []
        self.plans: list[PlanResult] = []
        self.texts: set[str] = set()
        self.told: Pose2D | None = None
        self.worst = 0.0
        self.clearance = 1.0
        self.sensing = True
        self.scan_every = 2
        self.uplink = self.downlink = 0
        self._cycle = 0
        self._sensed: deque[tuple[int, str, Payload]] = deque()
        self._in_force: deque[Twist] = deque()
        clone = {"model": "turtlebot2", "initial_pose": tuple(world.pose), **clone}
        build_clone(self.graph, None if maps else self.layers, **clone)  # type: ignore[arg-type]
        self._listen()

    def _listen(self) -> None:
        def hear(topic: str, message: object) -> None:
            match message:
                case Twist():
                    self.command = message
                    self.commands.append(message)
                case MoveBaseActionResult():
                    self.results.append(message)
                case PlanResult():
                    self.plans.append(message)
                case GoalStatusArray():
                    self.texts.update(status.text for status in message.status_list)
                case PoseWithCovarianceStamped():
                    self.told = message.pose.pose.planar()

        for topic in ("cmd_vel", "move_base/result", "plan", "move_base/status", "amcl_pose"):
            self.graph.tap(topic, hear)

    def send_goal(self, pose: Pose2D) -> None:
        """Publish a goal on move_base_simple/goal."""
        self.graph.inject("move_base_simple/goal", PoseStamped(Header(frame_id="map"), Pose.of(pose)))

    def step(self) -> None:
        """Simulate one period."""
        self.clock.advance(PERIOD)
        self._in_force.append(self.command)
        command = self._in_force.popleft() if len(self._in_force) > self.downlink else Twist()
        self.world.move(command.linear.x, command.angular.z, PERIOD)
        self.clearance = min(self.clearance, self.world.clearance())
        now = self.clock()
        if self.sensing:
            self.sense("odom", self.world.odometry(now))
            if self._cycle % self.scan_every == 0:
                self.sense("scan", self.world.scan(now))
                if self.told is not None:
                    self.worst = max(self.worst, error_of(self.told, self.world.pose)[0])
        self._cycle += 1
        self.graph.run_due()

    def sense(self, topic: str, message: Payload) -> None:
        """Send a message of one of the robot's sensors."""
        self._sensed.append((self._cycle, topic, message))
        while self._sensed and self._sensed[0][0] <= self._cycle - self.uplink:
            _, topic, message = self._sensed.popleft()
            self.graph.inject(topic, message)

    def run(self, seconds: float) -> None:
        """Simulate until a result comes, at most for a time [s]."""
        had = len(self.results)
        for _ in range(round(seconds / PERIOD)):
            if len(self.results) > had:
                return
            self.step()

    def last_status(self) -> Status:
        """Return the status of the last goal that ended."""
        return Status(self.results[-1].status.status)
