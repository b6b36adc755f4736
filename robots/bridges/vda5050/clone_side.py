"""Side of an AGV that is the robot in the cloud: executes commands, and reports poses, drives and actions."""

import math
from collections.abc import Callable, Coroutine
from typing import Any

import msgspec

from ppaas.clock import monotonic
from ppaas.decoding import from_json
from ppaas.errors import MalformedMessage, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Bool, Header, String
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.messages.nav2_msgs import SpeedLimit
from ppaas.messages.nav_msgs import Odometry, Path
from ppaas.messages.std_srvs import TriggerResponse
from ppaas.wire.own_topics import OWN_TOPICS, PRESENCE
from ppaas.wire.vda5050.agv.agv import Agv
from ppaas.wire.vda5050.agv.commands import Command, Drive, DriveResult, Execute, LimitSpeed, Localize, RobotPose, Stop
from ppaas.wire.vda5050.agv.report import Telemetry
from ppaas.wire.vda5050.fields import Velocity
from ppaas.wire.vda5050.orders import Action
from ppaas.wire.vda5050.states import PowerSupply
from robots.bridges.core.cloud_link import LOST, CloudGoal, CloudLink
from robots.bridges.vda5050.agv_options import AgvOptions

POSE_PERIOD = 0.2
"""Least time between two poses of a robot that drives [s]."""

SLOW_PERIOD = 1.0
"""Least time between two velocities, paths, messages of the battery, and poses of a robot that stands [s]."""

POSE_AGE = 3.0
"""Age of the last pose from which the robot counts as lost [s]."""

STANDING = 0.02
"""Velocity up to which a robot counts as standing [m/s, rad/s]."""

ACTION_TIMEOUT = 60.0
"""Time limit of an action of the robot [s]; the cloud's limit for calls."""

REACHED = 4
CHARGING = 1
"""Status of a goal that was reached, and of a battery that is charged, as ROS 2 numbers them."""

COVARIANCE = {0: 0.25, 7: 0.25, 35: 0.07}
"""Covariance of a pose that a master control sets, as of RViz: entries of a 6 × 6 matrix [m², rad²]."""

NAVIGATE = "nav2_msgs/action/NavigateToPose"
TRIGGER = "std_srvs/srv/Trigger"


class _Battery(msgspec.Struct):
    """``sensor_msgs/BatteryState``, which the cloud passes on without a check, as far as a state has it."""

    percentage: float | None = None
    voltage: float | None = None
    current: float | None = None
    power_supply_status: int = 0


class CloneSide:
    """Robot of an AGV.

    Parameters
    ----------
    agv : Agv
    telemetry : Telemetry
        Takes what the robot reports besides its pose.
    link : CloudLink
    options : AgvOptions
    changed : callable
        Called after each input of the AGV.
    start : callable
        Starts a coroutine in the background.
    """

    def __init__(
        self,
        agv: Agv,
        telemetry: Telemetry,
        link: CloudLink,
        options: AgvOptions,
        *,
        changed: Callable[[], None],
        start: Callable[[Coroutine[Any, Any, None]], None],
    ) -> None:
        self._agv, self._telemetry, self._link, self._options = agv, telemetry, link, options
        self._changed, self._start = changed, start
        self._located = -math.inf
        self._often: bool | None = None
        self._goal: CloudGoal | None = None
        self._robot_is_here = True

    async def subscribe(self) -> None:
        """Subscribe to the robot's topics."""
        link = self._link
        await self._subscribe_poses()
        await link.subscribe(PRESENCE, OWN_TOPICS[PRESENCE], self._presence_received)
        await link.subscribe("amcl/status", "std_msgs/String", self._status_received)
        await link.subscribe("odom", "nav_msgs/Odometry", self._odometry_received, period=SLOW_PERIOD)
        await link.subscribe(
            "battery_state", "sensor_msgs/msg/BatteryState", self._battery_received, period=SLOW_PERIOD
        )
        if self._options.version.major >= 3:
            await link.subscribe("plan", "nav_msgs/Path", self._path_received, period=SLOW_PERIOD)

    async def _subscribe_poses(self) -> None:
        self._often = self._agv.driving
        period = POSE_PERIOD if self._often else SLOW_PERIOD
        kind = "geometry_msgs/PoseWithCovarianceStamped"
        await self._link.subscribe("amcl_pose", kind, self._pose_received, period=period)

    # -- from the robot ------------------------------------------------------------------------------------------------

    def check(self) -> None:
        """Notice that the connection was lost or found, or that poses do not come any more."""
        if self._is_connected != self._agv.connected:
            self._agv.link(connected=self._is_connected)
            self._changed()
        if self._often is not None and self._often != self._agv.driving and self._agv.connected:
            self._start(self._subscribe_poses())
        if self._agv.pose is not None and monotonic() - self._located > POSE_AGE:
            self._agv.robot_at(None)
            self._telemetry.velocity = None
            if not self._agv.why_lost:
                self._agv.why_lost = f"no pose of the robot has come for {POSE_AGE:g} s"
            self._agv.robot_moves(moving=False)
            self._changed()

    @property
    def _is_connected(self) -> bool:
        """Whether the robot itself is connected to the cloud, as far as the cloud is reached."""
        return self._link.connected and self._robot_is_here

    def _presence_received(self, message: bytes) -> None:
        self._robot_is_here = decode(Bool, message).data
        self.check()

    def _pose_received(self, message: bytes) -> None:
        located = decode(PoseWithCovarianceStamped, message).pose
        pose, covariance = located.pose.planar(), located.covariance
        deviation = math.sqrt(max(0.0, covariance[0] + covariance[7])) if len(covariance) == 36 else 0.0
        self._located, self._agv.why_lost = monotonic(), ""
        self._agv.robot_at(RobotPose(*pose, deviation))
        self._changed()

    def _status_received(self, message: bytes) -> None:
        self._agv.why_lost = decode(String, message).data
        self._changed()

    def _odometry_received(self, message: bytes) -> None:
        twist = decode(Odometry, message).twist.twist
        speeds = twist.linear.x, twist.linear.y, twist.angular.z
        self._telemetry.velocity = Velocity(vx=speeds[0], vy=speeds[1], omega=speeds[2])
        self._agv.robot_moves(moving=any(abs(speed) > STANDING for speed in speeds))

    def _path_received(self, message: bytes) -> None:
        poses = [stamped.pose for stamped in decode(Path, message).poses if isinstance(stamped, PoseStamped)]
        self._telemetry.path = [(pose.position.x, pose.position.y) for pose in poses]

    def _battery_received(self, message: bytes) -> None:
        try:
            battery = from_json(message, _Battery)
        except msgspec.DecodeError as error:
            raise MalformedMessage(f"battery_state is not a sensor_msgs/BatteryState: {error}") from error
        if battery.percentage is None:
            return
        self._telemetry.information.clear()
        self._telemetry.power = PowerSupply(
            state_of_charge=min(max(100.0 * battery.percentage, 0.0), 100.0),
            charging=battery.power_supply_status == CHARGING,
            battery_voltage=battery.voltage,
            battery_current=battery.current,
        )

    # -- to the robot --------------------------------------------------------------------------------------------------

    async def execute(self, command: Command) -> None:
        """Execute a command of the AGV."""
        if isinstance(command, Drive):
            await self._drive(command)
        elif isinstance(command, Stop):
            await self._stop()
        elif isinstance(command, LimitSpeed):
            await self._link.publish("speed_limit", encode(SpeedLimit(command.speed)))
        elif isinstance(command, Localize):
            await self._localize(command)
        elif isinstance(command, Execute):
            self._start(self._act(command.action))

    async def _drive(self, drive: Drive) -> None:
        pose = Pose.of(Pose2D(drive.x, drive.y, drive.theta))
        goal = {"pose": {"header": {"frame_id": "map"}, "pose": pose}}
        sent = await self._link.send_goal("navigate_to_pose", NAVIGATE, msgspec.json.encode(goal), lambda _: None)
        self._goal = sent
        self._start(self._await_end(drive.number, sent))

    async def _await_end(self, number: int, goal: CloudGoal) -> None:
        end = await goal.end
        if end.status == REACHED:
            self._agv.drive_ended(number, DriveResult.REACHED)
        elif end.reason == LOST:
            self._agv.drive_ended(number, DriveResult.LOST)
            if self._is_connected:  # another session has begun: drive again
                self._agv.link(connected=True)
        else:
            self._agv.drive_ended(number, DriveResult.FAILED, end.reason or _message(end.result))
        self._changed()

    async def _stop(self) -> None:
        if self._goal is not None:
            await self._link.cancel_goal(self._goal)
            self._goal = None

    async def _localize(self, command: Localize) -> None:
        covariance = [COVARIANCE.get(index, 0.0) for index in range(36)]
        pose = PoseWithCovariance(Pose.of(Pose2D(command.x, command.y, command.theta)), covariance)
        await self._link.publish("initialpose", encode(PoseWithCovarianceStamped(Header(frame_id="map"), pose)))

    async def _act(self, action: Action) -> None:
        service = self._options.services[action.action_type]
        try:
            answer = decode(TriggerResponse, await self._link.call(service, TRIGGER, b"{}", ACTION_TIMEOUT))
            ok, text = answer.success, answer.message
        except PPaaSError as error:
            ok, text = False, str(error)
        self._agv.action_ended(action.action_id, ok=ok, result=text)
        self._changed()


def _message(result: bytes) -> str:
    """Return what a result of Nav2 says of a failure."""
    values = msgspec.json.decode(result)
    text = str(values.get("error_msg") or "") if isinstance(values, dict) else ""
    return text or "the goal was not reached, or another client cancelled or replaced it"
