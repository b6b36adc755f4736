"""A container's whole life, once, before the first is forked.

What is loaded, compiled and looked up for the first time is then done for all containers, and lies in memory that they
share. Without it each would do it again, in its own memory: half of what it needs, and 20 ms of its start.
"""

import asyncio
import math
import shutil
import threading
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path

import numpy as np
import uvloop
from numpy.typing import NDArray

from engine.container.entry import run
from engine.processes.run_dir import make_run_dir
from engine.protocols import machine_link, robot_link
from engine.protocols.framing import FrameStream
from engine.specs.containers import ContainerSpec, Launch, MapVersion, RobotConfig
from engine.specs.layer_files import write_layers
from ppaas.clock import epoch
from ppaas.controllers.registry import CONTROLLERS
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import PPaaSError, Unavailable, rebuild
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages import decode, encode
from ppaas.messages.geometry_msgs import (
    Pose,
    PoseStamped,
    PoseWithCovariance,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from ppaas.messages.message import Message
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.ppaas_msgs import ComputePathRequest, RobotState
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.std_msgs import Header, Time
from ppaas.navigation.parameters import MoveBaseParameters
from ppaas.navigation.recovery_sequence import recovery_behaviors
from ppaas.planners.registry import PLANNERS
from ppaas.recoveries.registry import RECOVERIES
from ppaas.robot_model.known_models import robot_model

TIMEOUT = 20.0
"""Seconds for each part; both together take a quarter of one."""

MODEL = "turtlebot2"
PARAMETERS = {
    "move_base": {"controller_frequency": 250.0},
    "dwa": {"acc_lim_x": 20.0, "acc_lim_theta": 40.0, "xy_goal_tolerance": 0.2, "yaw_goal_tolerance": 1.0},
}
"""Many cycles in a short time, and soon there."""

ROBOT = RobotConfig("rehearsal", MODEL, (0.0, 0.0, 0.0), "dijkstra", "dwa", PARAMETERS)

PERIOD = 0.004
"""Seconds between two messages of each sensor."""

HASTE = 15.0
"""How many times faster than it is told to the robot drives, so that it is soon there."""

GOAL = Pose2D(0.4, 0.1, 0.5)
PLANNER = "dijkstra"
"""The one that most ask for; what others need is loaded where they are asked for."""

QUESTIONS = 8
"""Plans without a robot; from about that many on the interpreter takes a function for one that is often called."""

RADIUS = 2.5
"""Of the round room [m]."""

_PILLAR, _GIRTH = (0.6, -0.9), 0.15
"""Centre and radius of what stands there and is not in the map [m]: plans across the map must mind it."""

_ANOTHER = RobotState(
    Header(frame_id="map"), PoseWithCovariance(Pose.of(Pose2D(-1.5, 0.0))), Twist(Vector3(x=0.2)), radius=0.2
)
"""A robot of the same map, which drives: what a clone computes of one that stands is less."""
_LONGEST_NAME = len("planning-link")
_SIDE, _RESOLUTION = 120, 0.05
_CLIENT = 1

Floats = NDArray[np.float64]
Stream = FrameStream[robot_link.FromContainer]
Play = Callable[[Stream], Awaitable[None]]


def load_plugins() -> None:
    """Load what a robot has plugged in that asks for nothing else."""
    PLANNERS.load(ROBOT.base_global_planner)
    CONTROLLERS.load(ROBOT.base_local_planner)
    for behavior in recovery_behaviors(MoveBaseParameters()):
        RECOVERIES.load(behavior.type)


def rehearse() -> set[str]:
    """Be the clone of a robot that drives to a goal, then a container that only plans; return the topics heard.

    Nothing is left of it, neither threads nor files.

    Raises
    ------
    TimeoutError
        The robot did not get there.
    PPaaSError
        The container refused something.
    OSError
        No room for the files.
    """
    before = set(threading.enumerate())
    heard: set[str] = set()
    folder = make_run_dir(_LONGEST_NAME)
    try:
        write_layers(folder, build_layers(_round_room(), robot_radius=robot_model(MODEL).robot_radius), created=0.0)
        uvloop.run(_stage(folder, ROBOT, lambda stream: _drive(stream, heard)))
        uvloop.run(_stage(folder, None, _ask))
    finally:
        shutil.rmtree(folder)
    for thread in set(threading.enumerate()) - before:
        thread.join()  # a thread in a process that forks may hold locks that nobody gives back in the child
    return heard


def _round_room() -> GridMap:
    middles = (np.arange(_SIDE) + 0.5 - _SIDE / 2) * _RESOLUTION
    occupied = np.hypot(middles[:, None], middles) >= RADIUS
    corner = -_SIDE / 2 * _RESOLUTION
    return GridMap(
        np.where(occupied, 100, 0).astype(np.int8), GridInfo(_RESOLUTION, _SIDE, _SIDE, Pose2D(corner, corner))
    )


# -- the other ends of the two links -----------------------------------------------------------------------------------


async def _stage(folder: Path, robot: RobotConfig | None, play: Play) -> None:
    """Run one container between a machine that grants everything and an endpoint that plays its part."""
    played: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    async def endpoint(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        stream: Stream = FrameStream(reader, writer, robot_link.FromContainer)
        try:
            await play(stream)
        except PPaaSError as error:
            if not played.done():
                played.set_exception(error)
        else:
            played.set_result(None)
        stream.write(robot_link.Stop())
        while await stream.receive() is not None:
            pass
        await stream.close()

    spec = ContainerSpec("rehearsal", "rehearsal", MapVersion("rehearsal", "1"), 1.0, robot)
    dialled, machine = (str(folder / f"{spec.kind}-{end}") for end in ("link", "gate"))
    launch = Launch(spec, str(folder), dialled, machine, secret="", cpus=(), threads=1)
    servers = [
        await asyncio.start_unix_server(endpoint, launch.link),
        await asyncio.start_unix_server(_grant, launch.machine),
    ]
    try:
        async with asyncio.timeout(TIMEOUT):
            await run(launch)
            await played
    finally:
        played.cancel()
        for server in servers:
            server.close()


async def _grant(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    stream: FrameStream[machine_link.FromContainer] = FrameStream(reader, writer, machine_link.FromContainer)
    while (frame := await stream.receive()) is not None:
        if isinstance(frame, machine_link.SaveClone | machine_link.KeepPlan):
            stream.write(machine_link.Done(frame.request))
        elif isinstance(frame, machine_link.AskHistory):
            stream.write(machine_link.History(frame.request, [], "rehearsal", None))
        elif isinstance(frame, machine_link.Share):
            stream.write(machine_link.Shared("rehearsal", "another", frame.topic, encode(_ANOTHER)))
    await stream.close()


async def _next(stream: Stream) -> robot_link.FromContainer:
    frame = await stream.receive()
    if frame is None:
        raise Unavailable("the container ended")
    if isinstance(frame, robot_link.Refused | robot_link.Failed):
        raise rebuild(frame.refusal.slug, frame.refusal.text)
    return frame


async def _ask(stream: Stream) -> None:
    await _next(stream)
    for number in range(QUESTIONS):
        question = encode(ComputePathRequest(Pose.of(Pose2D(0.0, 0.0)), Pose.of(GOAL), PLANNER))
        stream.write(robot_link.Call(number, "compute_path", question))
        await _next(stream)


async def _drive(stream: Stream, heard: set[str]) -> None:
    hello = await _next(stream)
    if isinstance(hello, robot_link.Hello):
        for topic in hello.topics:
            stream.write(robot_link.Subscribe(topic.name, _CLIENT))
    robot = _Robot()
    sensing = asyncio.create_task(_sense(stream, robot))
    try:
        await _listen(stream, robot, heard)
    finally:
        sensing.cancel()


async def _listen(stream: Stream, robot: "_Robot", heard: set[str]) -> None:
    while "move_base/result" not in heard:
        frame = await _next(stream)
        if isinstance(frame, robot_link.Published):
            if frame.topic == "amcl_pose" and "amcl_pose" not in heard:
                goal = PoseStamped(Header(frame_id="map"), Pose.of(GOAL))
                stream.write(robot_link.Deliver("move_base_simple/goal", encode(goal), _CLIENT, sequence=1))
            elif frame.topic == "cmd_vel":
                robot.told = decode(Twist, frame.payload)
            heard.add(frame.topic)


async def _sense(stream: Stream, robot: "_Robot") -> None:
    while True:
        for topic, message in robot.sense():
            stream.write(robot_link.Deliver(topic, encode(message), _CLIENT))
        await asyncio.sleep(PERIOD)
        robot.move(HASTE * PERIOD)


class _Robot:
    """A robot without a fault in the round room."""

    def __init__(self) -> None:
        self.told = Twist()
        self._pose = Pose2D(0.0, 0.0)
        self._angles = np.linspace(-math.pi / 2, math.pi / 2, 181)

    def move(self, seconds: float) -> None:
        self._pose = self._pose @ Pose2D(self.told.linear.x * seconds, 0.0, self.told.angular.z * seconds)

    def sense(self) -> Iterator[tuple[str, Message]]:
        stamp = Time.of(epoch())
        pose = PoseWithCovariance(Pose.of(self._pose))
        yield "odom", Odometry(Header(stamp=stamp, frame_id="odom"), "base_link", pose, TwistWithCovariance(self.told))
        header, angles = Header(stamp=stamp, frame_id="base_link"), self._angles
        first, second, last = map(float, angles[[0, 1, -1]])
        yield "scan", LaserScan(header, first, last, second - first, 0.1, 2.0 * RADIUS, self._ranges())

    def _ranges(self) -> list[float | None]:
        x, y, theta = self._pose
        wall = _to_circle(-x, -y, RADIUS, self._angles + theta)[1]
        pillar = _to_circle(_PILLAR[0] - x, _PILLAR[1] - y, _GIRTH, self._angles + theta)[0]
        ranges: list[float | None] = np.fmin(wall, np.where(pillar > 0.0, pillar, np.nan)).tolist()
        return ranges


def _to_circle(x: float, y: float, radius: float, angles: Floats) -> tuple[Floats, Floats]:
    """Return how far it is along each angle to where a circle begins and ends [m], NaN beside it."""
    along = x * np.cos(angles) + y * np.sin(angles)
    squared = along**2 + radius**2 - x**2 - y**2
    half = np.sqrt(np.where(squared >= 0.0, squared, np.nan))
    return along - half, along + half
