"""A robot's clone in this process, by a clock that is simulated: what the cloud would run in a container."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ppaas.clock import Clock
from ppaas.clone.assembly import build_clone
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.geometry_msgs import Point, Pose, PoseStamped, Twist
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.people_msgs import People, Person
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.std_msgs import Header, Time
from ppaas.nodes import topics
from ppaas.nodes.amcl.messages import ParticleCloud
from ppaas.nodes.base import Payload
from ppaas.nodes.frames import MAP
from ppaas.nodes.graph import Graph
from ppaas.nodes.jobs import Work, run_inline
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.planners.base import PlanResult

T = TypeVar("T")

MODEL = "turtlebot2"
PLANNING = 0.1
"""Seconds of the simulated clock that a plan takes, or to look for a lost robot: the robot drives on meanwhile."""
RECOVERING = "recovering by"
"""So Move Base tells that it recovers."""


@dataclass(frozen=True, slots=True)
class GoalEnd:
    """How a goal ended: the status of its action, and Move Base's words."""

    status: Status
    text: str


class InProcessClone:
    """All nodes of a clone.

    Parameters
    ----------
    layers : MapLayers
        The map.
    start : Pose2D
        Where the robot is said to be.
    controller : str
        Local planner.
    parameters : dict
        Of nodes and plug-ins, as a robot's file gives them.
    clock : callable
        Simulated seconds since the epoch.

    Attributes
    ----------
    recoveries : int
        How often Move Base began to recover.
    end : GoalEnd or None
        Of the goal that it was given last, once that has ended.
    particles : (n, 3) array
        Of localization, as it told of them last: x, y [m], theta [rad].
    plan : PlanResult or None
        That it follows, or followed last.

    Raises
    ------
    NotFound, InvalidParameter
        As `ppaas.clone.assembly.build_clone`.
    """

    def __init__(
        self, layers: MapLayers, start: Pose2D, controller: str, parameters: dict[str, Any], clock: Clock
    ) -> None:
        self.recoveries = 0
        self.end: GoalEnd | None = None
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
            base_local_planner=controller, parameters=parameters,
        )  # fmt: skip
        for topic in ("cmd_vel", "plan", "particlecloud", topics.MOVE_BASE_STATUS.name, topics.MOVE_BASE_RESULT.name):
            self.graph.tap(topic, self._hear)

    def odometry(self, message: Odometry) -> None:
        """Take what odometry tells."""
        self.graph.inject("odom", message)

    def scan(self, message: LaserScan) -> None:
        """Take what the laser sees."""
        self.graph.inject("scan", message)

    def people(self, positions: NDArray[np.float64], velocities: NDArray[np.float64]) -> None:
        """Take where people are, (n, 2) x, y [m], and how they walk, (n, 2) [m/s], as if somebody told."""
        header = Header(stamp=Time.of(self._clock()), frame_id=MAP)
        told = [
            Person(str(index), Point(*place), Point(*way))
            for index, (place, way) in enumerate(zip(positions.tolist(), velocities.tolist(), strict=True))
        ]
        self.graph.inject("people", People(header, told))

    @property
    def costs(self) -> Costmap | None:
        """The local costmap, as Move Base saw it last."""
        move_base = self.graph.nodes[MoveBaseNode.name]
        assert isinstance(move_base, MoveBaseNode)
        return move_base.costs

    def send_to(self, goal: Pose2D) -> None:
        """Send the robot to a pose in the map."""
        self.end = None
        header = Header(stamp=Time.of(self._clock()), frame_id=MAP)
        self.graph.inject(topics.SIMPLE_GOAL.name, PoseStamped(header, Pose.of(goal)))

    def cancel(self) -> None:
        """Give the goal up."""
        self.graph.inject(topics.MOVE_BASE_CANCEL.name, GoalID())

    def command(self) -> Twist | None:
        """Let the clone do what is due by now; return the velocity that it sent last, if it sent any."""
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
                self.end = GoalEnd(Status(message.status.status), message.status.text)

    def _note(self, text: str) -> None:
        if text.startswith(RECOVERING) and text != self._text:
            self.recoveries += 1
        self._text = text
