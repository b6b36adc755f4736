"""Clone of a robot in this process with a simulated clock: the nodes that the cloud would run in a container."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ppaas.clock import Clock
from ppaas.clone.assembly import build_clone
from ppaas.clone.plugins import DEFAULT_PLANNER
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, PoseStamped, Twist
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.people_msgs import People, Person
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes import topics
from ppaas.nodes.amcl.messages import ParticleCloud
from ppaas.nodes.base import Payload
from ppaas.nodes.frames import MAP
from ppaas.nodes.graph import Graph
from ppaas.nodes.jobs import Work, run_inline
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.planners.base import PlanResult
from robots.sim.driver import FixedRate, SensorRates
from robots.sim.robot import SimulatedRobot
from robots.sim.world import World

T = TypeVar("T")

MODEL = "turtlebot2"
"""Model of the robot."""
PLANNING = 0.1
"""Simulated time of a background job, such as a plan or the search for a lost robot [s]; the robot drives meanwhile."""
RECOVERING = "recovering by"
"""Begin of the status text of Move Base during a recovery."""


@dataclass(frozen=True, slots=True)
class CloneGoalEnd:
    """End of a goal: final status of the action, and its text."""

    status: Status
    text: str


class InProcessClone:
    """Nodes of a clone, run step by step.

    Parameters
    ----------
    layers : MapLayers or None
        Layers of the map; None for a robot that makes one.
    start : Pose2D
        Initial pose of the robot.
    controller : str
        Name of the local planner.
    parameters : dict
        Parameters of nodes and plug-ins, as in a robot's file.
    clock : callable
        Simulated time since the epoch [s].
    robot : str, optional
        Robot ID.
    planner : str, optional
        Name of the global planner.

    Attributes
    ----------
    recoveries : int
        Number of recoveries that Move Base began.
    end : CloneGoalEnd or None
        End of the last goal; None until it has ended.
    particles : (n, 3) array
        Last particles of localization: x, y [m], theta [rad].
    plan : PlanResult or None
        Last plan.

    Raises
    ------
    NotFound, InvalidParameter
        As `ppaas.clone.assembly.build_clone`.
    """

    def __init__(
        self,
        layers: MapLayers | None,
        start: Pose2D,
        controller: str,
        parameters: dict[str, Any],
        clock: Clock,
        *,
        robot: str = "robot",
        planner: str = DEFAULT_PLANNER,
    ) -> None:
        self.recoveries = 0
        self.end: CloneGoalEnd | None = None
        self.particles: NDArray[np.float64] = np.empty((0, 3))
        self.plan: PlanResult | None = None
        self._clock = clock
        self._text = ""
        self._jobs: deque[tuple[float, Callable[[], None]]] = deque()
        self._command_sent: Twist | None = None
        self.graph = Graph(self._work, clock, clock)
        build_clone(
            self.graph, layers,
            model=MODEL, initial_pose=(start.x, start.y, start.theta),
            base_global_planner=planner, base_local_planner=controller, parameters=parameters, robot=robot,
        )  # fmt: skip
        heard = ("cmd_vel", "plan", topics.MOVE_BASE_STATUS.name, topics.MOVE_BASE_RESULT.name)
        for topic in heard if layers is None else (*heard, "particlecloud"):
            self.graph.tap(topic, self._hear)

    def odometry(self, message: Odometry) -> None:
        """Publish odometry to the clone."""
        self.graph.inject("odom", message)

    def scan(self, message: LaserScan) -> None:
        """Publish a scan to the clone."""
        self.graph.inject("scan", message)

    def people(self, positions: NDArray[np.float64], velocities: NDArray[np.float64]) -> None:
        """Publish positions (n, 2) [m] and velocities (n, 2) [m/s] of people, as an external detector would."""
        header = Header(stamp=Time.of(self._clock()), frame_id=MAP)
        told = [
            Person(str(index), Point(*place), Point(*way))
            for index, (place, way) in enumerate(zip(positions.tolist(), velocities.tolist(), strict=True))
        ]
        self.graph.inject("people", People(header, told))

    @property
    def costs(self) -> Costmap | None:
        """Last local costmap of Move Base."""
        move_base = self.graph.nodes[MoveBaseNode.name]
        assert isinstance(move_base, MoveBaseNode)
        return move_base.costs

    def send_to(self, goal: Pose2D) -> None:
        """Send the robot to a pose in the map frame."""
        self.end = None
        header = Header(stamp=Time.of(self._clock()), frame_id=MAP)
        self.graph.inject(topics.SIMPLE_GOAL.name, PoseStamped(header, Pose.of(goal)))

    def cancel(self) -> None:
        """Cancel the goal."""
        self.graph.inject(topics.MOVE_BASE_CANCEL.name, GoalID())

    def command(self) -> Twist | None:
        """Run everything that is due; return the last velocity that the clone sent, or None."""
        self._command_sent = None
        while self._jobs and self._jobs[0][0] <= self._clock():
            self._jobs.popleft()[1]()
        self.graph.run_due()
        return self._command_sent

    def _work(self, work: Work[T], cancelled: Callable[[], bool], done: Callable[[T | PPaaSError], None]) -> None:
        self._jobs.append((self._clock() + PLANNING, lambda: run_inline(work, cancelled, done)))

    def _hear(self, topic: str, message: Payload) -> None:
        match message:
            case Twist():
                self._command_sent = message
            case PlanResult():
                self.plan = message
            case ParticleCloud():
                self.particles = message.particles
            case GoalStatusArray():
                self._note(message.status_list[-1].text if message.status_list else "")
            case MoveBaseActionResult():
                self.end = CloneGoalEnd(Status(message.status.status), message.status.text)

    def _note(self, text: str) -> None:
        if text.startswith(RECOVERING) and text != self._text:
            self.recoveries += 1
        self._text = text


class ClonedRobot:
    """Simulated robot and its clone: passes sensors to the clone and commands to the wheels.

    Parameters
    ----------
    world : World
    body : SimulatedRobot
        A robot of the world.
    clone : InProcessClone
    """

    def __init__(self, world: World, body: SimulatedRobot, clone: InProcessClone) -> None:
        self.body = self._simulated = body
        self._world, self.clone = world, clone
        rates = SensorRates()
        self._odometry, self._scan = FixedRate(rates.odom, 0.0), FixedRate(rates.scan, 0.0)

    def step(self) -> None:
        """Pass odometry and scans that are due to the clone, and its command to the wheels."""
        now = self._world.time()
        if self._odometry.take(now):
            self.clone.odometry(self._simulated.odometry())
        if self._scan.take(now):
            self.clone.scan(self._simulated.scan())
        command = self.clone.command()
        if command is not None:
            self._simulated.command(command)
