"""Scripted session: runs a container from start to end in the fork server, before the first container is forked.

First-time work, such as imports, compilation and lookups, is then done for all containers, in memory that they share.
Without it each container would repeat it in its own memory: half of its memory, and 20 ms of its start.
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
from engine.container.warm_up.plugins import MODEL, ROBOT
from engine.processes.run_dir import make_run_dir
from engine.protocols import machine_link, robot_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import error_of
from engine.protocols.session_frames import Attach, SessionClient, SessionOptions
from engine.rights.access import Access
from engine.specs.containers import ContainerSpec, Launch, MapVersion, RobotConfig
from engine.specs.layer_files import write_layers
from ppaas.clock import epoch
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import PPaaSError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import (
    Pose,
    PoseStamped,
    PoseWithCovariance,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.ppaas_msgs import ComputePathRequest, RobotState
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.robot_model.known_models import robot_model

RADIUS = 2.5
"""Radius of the round room [m]."""

_PILLAR, _GIRTH = (0.6, -0.9), 0.15
"""Centre and radius of the pillar [m], which is not in the map: plans must avoid it."""

_SIDE, _RESOLUTION = 120, 0.05
"""Side of the map [cells] and its resolution [m/cell]."""

Floats = NDArray[np.float64]


def round_room() -> GridMap:
    """Return the map of the room, without the pillar."""
    middles = (np.arange(_SIDE) + 0.5 - _SIDE / 2) * _RESOLUTION
    occupied = np.hypot(middles[:, None], middles) >= RADIUS
    corner = -_SIDE / 2 * _RESOLUTION
    return GridMap(
        np.where(occupied, 100, 0).astype(np.int8), GridInfo(_RESOLUTION, _SIDE, _SIDE, Pose2D(corner, corner))
    )


class SensingRobot:
    """Robot in the round room that drives with the velocity ``command``."""

    def __init__(self) -> None:
        self.command = Twist()
        self._pose = Pose2D(0.0, 0.0)
        self._angles = np.linspace(-math.pi / 2, math.pi / 2, 181)

    def move(self, seconds: float) -> None:
        """Drive for some time [s]."""
        self._pose = self._pose @ Pose2D(self.command.linear.x * seconds, 0.0, self.command.angular.z * seconds)

    def sense(self) -> Iterator[tuple[str, Message]]:
        """Yield the current sensor messages with their topics."""
        stamp = Time.of(epoch())
        pose, twist = PoseWithCovariance(Pose.of(self._pose)), TwistWithCovariance(self.command)
        yield "odom", Odometry(Header(stamp=stamp, frame_id="odom"), "base_link", pose, twist)
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
    """Return the distances along each angle [rad] at which a ray enters and leaves a circle [m]; NaN if it misses."""
    along = x * np.cos(angles) + y * np.sin(angles)
    squared = along**2 + radius**2 - x**2 - y**2
    half = np.sqrt(np.where(squared >= 0.0, squared, np.nan))
    return along - half, along + half


TIMEOUT = 20.0
"""Time limit of each of the two parts [s]; both together take 0.25 s."""

PERIOD = 0.004
"""Period of each sensor [s]."""

HASTE = 15.0
"""Factor by which the robot drives faster than commanded, to arrive soon."""

GOAL = Pose2D(0.4, 0.1, 0.5)
PLANNER = "dijkstra"
"""The most used planner; others are loaded on their first use."""

QUESTIONS = 8
"""Number of planning requests without a robot; after about so many calls the interpreter specializes a function."""

_ANOTHER = RobotState(
    Header(frame_id="map"), PoseWithCovariance(Pose.of(Pose2D(-1.5, 0.0))), Twist(Vector3(x=0.2)), radius=0.2
)
"""Another robot on the same map, which drives: a clone computes less for one that stands still."""

_ATTACHED = Attach(
    1, SessionClient("warm-up", "warm-up", ROBOT.id, "robot"), SessionOptions(), Access.of_owner(ROBOT.id), "warm-up"
)
"""Socket of the robot: without it, the clone shares nothing with others."""

_LONGEST_NAME = len("planning-link")
_CLIENT = 1

Stream = FrameStream[robot_link.FromContainer]
Play = Callable[[Stream], Awaitable[None]]


def warm_up() -> set[str]:
    """Run the clone of a robot that drives to a goal, then a planning container; return the topics of its messages.

    No threads or files are left behind.

    Raises
    ------
    TimeoutError
        The robot did not reach its goal in time.
    PPaaSError
        The container refused a message, or failed.
    OSError
        There is no space for the files.
    """
    before = set(threading.enumerate())
    heard: set[str] = set()
    folder = make_run_dir(_LONGEST_NAME)
    try:
        write_layers(folder, build_layers(round_room(), robot_radius=robot_model(MODEL).robot_radius), created=0.0)
        uvloop.run(_stage(folder, ROBOT, lambda stream: _drive(stream, heard)))
        uvloop.run(_stage(folder, None, _ask))
    finally:
        shutil.rmtree(folder)
    for thread in set(threading.enumerate()) - before:
        thread.join()  # a running thread may hold locks that a forked child cannot release
    return heard


# -- the other ends of the two links -----------------------------------------------------------------------------------


async def _stage(folder: Path, robot: RobotConfig | None, play: Play) -> None:
    """Run one container, with a machine that accepts all requests and an endpoint that runs ``play``."""
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
        stream.write(robot_link.Shutdown())
        while await stream.receive() is not None:
            pass
        await stream.close()

    spec = ContainerSpec("warm-up", "warm-up", MapVersion("warm-up", "1"), 1.0, robot)
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
            stream.write(machine_link.PlanningHistory(frame.request, [], "warm-up", None))
        elif isinstance(frame, machine_link.FabricPublish):
            stream.write(machine_link.Shared("warm-up", "another", frame.topic, encode(_ANOTHER)))
    await stream.close()


async def _next(stream: Stream) -> robot_link.FromContainer:
    frame = await stream.receive()
    if frame is None:
        raise Unavailable("the container exited during the warm-up")
    if isinstance(frame, robot_link.MessageRefused | robot_link.ContainerFailed):
        raise error_of(frame.refusal)
    return frame


async def _ask(stream: Stream) -> None:
    await _next(stream)
    for number in range(QUESTIONS):
        question = encode(ComputePathRequest(Pose.of(Pose2D(0.0, 0.0)), Pose.of(GOAL), PLANNER))
        stream.write(robot_link.ServiceCall(number, "compute_path", question))
        await _next(stream)


async def _drive(stream: Stream, heard: set[str]) -> None:
    hello = await _next(stream)
    if isinstance(hello, robot_link.Hello):
        for topic in hello.topics:
            stream.write(robot_link.SubscribeTopic(topic.name, _CLIENT))
        stream.write(_ATTACHED)
    robot = SensingRobot()
    sensing = asyncio.create_task(_sense(stream, robot))
    try:
        await _listen(stream, robot, heard)
    finally:
        sensing.cancel()


async def _listen(stream: Stream, robot: SensingRobot, heard: set[str]) -> None:
    while "move_base/result" not in heard:
        frame = await _next(stream)
        if isinstance(frame, robot_link.Published):
            if frame.topic == "amcl_pose" and "amcl_pose" not in heard:
                goal = PoseStamped(Header(frame_id="map"), Pose.of(GOAL))
                stream.write(robot_link.Deliver("move_base_simple/goal", encode(goal), _CLIENT, sequence=1))
            elif frame.topic == "cmd_vel":
                robot.command = decode(Twist, frame.payload)
            heard.add(frame.topic)


async def _sense(stream: Stream, robot: SensingRobot) -> None:
    while True:
        for topic, message in robot.sense():
            stream.write(robot_link.Deliver(topic, encode(message), _CLIENT))
        await asyncio.sleep(PERIOD)
        robot.move(HASTE * PERIOD)
