"""Fleet bridge: shares a clone's position with the robots on the same map, and stores its plans."""

import logging
from collections.abc import Callable

import msgspec

from engine.container.machine_client import MachineClient
from engine.processes.background import Background
from engine.processes.occasional_log import OccasionalLog
from engine.protocols import machine_link
from engine.specs.containers import ContainerSpec, Launch
from ppaas.clone.robot_body import robot_body
from ppaas.errors import PPaaSError
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import TrafficReport
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped, Twist
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.ppaas_msgs import RobotState, RobotStates
from ppaas.nodes import topics
from ppaas.nodes.base import Payload
from ppaas.nodes.frames import MAP
from ppaas.nodes.graph import Graph
from ppaas.nodes.other_robots import checked_state
from ppaas.planners.base import PlanResult, pose_message
from storage.records import PlanRecord

logger = logging.getLogger(__name__)

SHARE_PERIOD = 0.2
"""Smallest time between two shared positions [s]: at 0.65 m/s a robot moves 13 cm in it."""

TELL_PERIOD = 0.09
"""Smallest time between two messages to the clone about other robots [s]; limits the cost with many robots. It is a
little less than the time between two batches of positions from the machine."""

FRESH = 1.0
"""Age at which the position of another robot, or the own velocity or report to the traffic node, is discarded [s]."""


RobotIsHere = Callable[[], bool]
"""Returns whether the robot of a clone is connected."""


def plan_record(launch: Launch, plan: PlanResult, created: float) -> PlanRecord:
    """Return the record of a plan; equal plans on the same map version have the same id, so they are stored once."""
    spec = launch.spec
    first, last = (pose_message(row).planar() for row in plan.poses[[0, -1]].tolist())
    return PlanRecord(
        id=plan.id,
        user=spec.user,
        map=spec.map.id,
        version=spec.map.version,
        planner=plan.planner,
        start=first,
        goal=last,
        length=plan.length,
        cost=plan.cost,
        seconds=plan.seconds,
        poses=plan.poses.astype("<f8").tobytes(),
        created=created,
        robot=spec.robot.id if spec.robot else None,
        parameters=plan.conditions,
        origin=plan.origin,
    )


def _radius_of(spec: ContainerSpec) -> float:
    robot = spec.robot
    return robot_body(robot.model, robot.urdf, robot.parameters).robot_radius if robot else 0.0


class FleetBridge:
    """Bridge between a clone's graph and the machine link.

    While the robot is not connected, no position of it is shared: others would take a guess for the robot.

    Parameters
    ----------
    launch : Launch
        Specification of the container.
    graph : Graph
        Graph of the clone.
    machine : MachineClient
        The machine link.
    robot_is_here : callable
        Returns whether the robot is connected.
    """

    def __init__(self, launch: Launch, graph: Graph, machine: MachineClient, robot_is_here: RobotIsHere) -> None:
        self._robot_is_here = robot_is_here
        self._launch = launch
        self._graph = graph
        self._machine = machine
        self._last_shared = self._last_told = float("-inf")
        self._refused: set[tuple[str, str]] = set()
        self._others: dict[tuple[str, str], tuple[float, RobotState]] = {}
        self._background = Background()
        self._unstored = OccasionalLog(logger)
        self._kept: tuple[bytes, float] | None = None
        self._driven: tuple[float, Twist] = float("-inf"), Twist()
        self._granted_at = float("-inf")
        robot = launch.spec.robot
        self._itself = launch.spec.user, "" if robot is None else robot.id
        self._radius = _radius_of(launch.spec)
        self._frame, self._is_joint = MAP, bool(launch.spec.joint_map)
        # Other robots share the frame of a new map only while it continues a published or a joint one.
        shared = topics.SHARED_POSE if launch.spec.maps else topics.AMCL_POSE
        if shared.name in graph.topics:
            graph.tap(shared.name, self._share_pose)
        if topics.ODOM.name in graph.topics:
            graph.tap(topics.ODOM.name, self._note_velocity)
        if topics.TRAFFIC_REPORT.name in graph.topics and not launch.spec.maps:
            graph.tap(topics.TRAFFIC_REPORT.name, self._note_traffic)
        if topics.PLAN.name in graph.topics and not launch.spec.maps:
            graph.tap(topics.PLAN.name, self._keep_plan)

    def use_spec(self, spec: ContainerSpec) -> None:
        """Store plans for the map version of another spec, and share the size of its robot, from now on."""
        self._launch = msgspec.structs.replace(self._launch, spec=spec)
        self._radius = _radius_of(spec)

    def _note_velocity(self, _topic: str, odometry: Payload) -> None:
        if isinstance(odometry, Odometry):
            self._driven = self._graph.elapsed(), odometry.twist.twist

    def _note_traffic(self, _topic: str, report: Payload) -> None:
        if isinstance(report, TrafficReport):
            self._granted_at = float("-inf") if report.free or report.stray else self._graph.elapsed()

    def _share_pose(self, _topic: str, pose: Payload) -> None:
        now = self._graph.elapsed()
        if now - self._last_shared < SHARE_PERIOD or not isinstance(pose, PoseWithCovarianceStamped):
            return
        if not self._robot_is_here():
            return
        if self._launch.spec.maps and not self._is_in_frame(pose.header.frame_id):
            return
        self._last_shared = now
        since, twist = self._driven
        driven, granted = twist if now - since < FRESH else Twist(), now - self._granted_at < FRESH
        state = RobotState(pose.header, pose.pose, driven, self._radius, granted)
        self._machine.share(topics.AMCL_POSE.name, encode(state))

    def _is_in_frame(self, frame: str) -> bool:
        """Return whether other robots may know the frame of a pose; note it if a map that is to be joined has it."""
        if self._is_joint and frame != self._frame:
            self._frame = frame
            self._others.clear()
        return frame == self._frame

    def shared(self, *messages: machine_link.Shared) -> None:
        """Take positions and velocities of other robots on this map, and publish all recent ones to the clone.

        Positions of this robot itself, and in the frame of a map that is not joined with this one, are ignored. A
        payload that is not a valid state is dropped, and logged once for each robot.
        """
        if topics.ROBOTS.name not in self._graph.topics:
            return
        if self._launch.spec.maps and self._graph.elapsed() - self._last_shared >= FRESH:
            return  # its map has left the frame of the published one, or nothing is known of it
        taken = [message.topic == topics.AMCL_POSE.name and self._take(message) for message in messages]
        if any(taken):
            self._tell_others()

    def _take(self, message: machine_link.Shared) -> bool:
        """Store the state of another robot; return whether there is one."""
        who = message.user, message.robot
        if who == self._itself:
            return False
        try:
            state = checked_state(decode(RobotState, message.payload))
        except PPaaSError as error:
            level = logging.DEBUG if who in self._refused else logging.WARNING
            logger.log(level, "robot %s of user %s shared an invalid position: %s", message.robot, message.user, error)
            self._refused.add(who)
            return False
        if self._is_joint and state.header.frame_id != self._frame:
            return False
        self._others[who] = (self._graph.elapsed(), state)
        return True

    def _tell_others(self) -> None:
        now = self._graph.elapsed()
        if now - self._last_told < TELL_PERIOD:
            return  # its next position arrives before this one is too old
        self._last_told = now
        self._others = {who: seen for who, seen in self._others.items() if now - seen[0] < FRESH}
        states = [state for _, state in self._others.values()]
        poses, twists = [state.pose.pose for state in states], [state.twist for state in states]
        header = Header(stamp=Time.of(self._graph.now()), frame_id="map")
        radii, granted = [state.radius for state in states], self._granted()
        own = [robot if owner == self._launch.spec.user else "" for owner, robot in self._others]
        names = own if any(own) else []
        self._graph.inject(topics.ROBOTS.name, RobotStates(header, poses, twists, radii, granted, names))

    def _granted(self) -> list[bool]:
        """Return whether each of the other robots drives by grants of this user's traffic node; empty if none does."""
        user = self._launch.spec.user
        granted = [state.granted and owner == user for (owner, _), (_, state) in self._others.items()]
        return granted if any(granted) else []

    def _keep_plan(self, _topic: str, plan: Payload) -> None:
        if isinstance(plan, PlanResult) and len(plan.poses) and self._is_news(plan) and plan.id != plan.reused:
            self._background.run(self._keep(plan_record(self._launch, plan, self._graph.now())))

    def _is_news(self, plan: PlanResult) -> bool:
        """Return whether a plan has a new goal or is a detour, and not a renewal while the robot follows it."""
        goal = plan.poses[-1].tobytes()
        if self._kept is not None and self._kept[0] == goal and plan.length <= self._kept[1]:
            return False
        self._kept = goal, plan.length
        return True

    async def _keep(self, plan: PlanRecord) -> None:
        try:
            await self._machine.keep_plan(plan)
        except PPaaSError as error:
            self._unstored.warning("a plan was not stored: %s", error)
