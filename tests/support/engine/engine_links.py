"""Peers of the engine's links, over its real sockets."""

import asyncio
import socket
from pathlib import Path
from typing import Any

from engine.protocols import control_link, machine_link, robot_link
from engine.protocols.framing import FrameStream
from ppaas import __version__
from tests.support.waiting import patience

HELLO_TOPICS = [
    robot_link.TopicInfo("map", "nav_msgs/OccupancyGrid", True),
    robot_link.TopicInfo("goal", "std_msgs/String", False),
    robot_link.TopicInfo("cmd_vel", "geometry_msgs/Twist", False),
    robot_link.TopicInfo("scan", "sensor_msgs/LaserScan", False),
    robot_link.TopicInfo("odom", "nav_msgs/Odometry", False),
]

HELLO_SERVICES = [robot_link.ServiceInfo("make_plan", "nav_msgs/GetPlan")]
HELLO_NODES = [robot_link.NodeInfo("move_base", ("cmd_vel",), ("goal",), ("make_plan",))]


async def _dial(path: Path | str, incoming: Any) -> FrameStream[Any]:
    return FrameStream(*await asyncio.open_unix_connection(path), incoming)


async def dial_link(path: Path | str) -> FrameStream[robot_link.ToContainer]:
    """Dial the robot link as a container does."""
    return await _dial(path, robot_link.ToContainer)


async def dial_control(path: Path | str) -> FrameStream[control_link.ToAgent]:
    """Dial the control link as an agent does."""
    return await _dial(path, control_link.ToAgent)


async def dial_gateway(path: Path | str) -> FrameStream[machine_link.ToContainer]:
    """Dial the container gateway of a machine as a container does."""
    return await _dial(path, machine_link.ToContainer)


async def pair(near: Any, far: Any) -> tuple[FrameStream[Any], FrameStream[Any]]:
    """Return the two ends of a new connection, by the types that they receive."""
    ours, theirs = socket.socketpair()
    return (
        FrameStream(*await asyncio.open_connection(sock=ours), near),
        FrameStream(*await asyncio.open_connection(sock=theirs), far),
    )


async def connection(incoming: Any) -> tuple[FrameStream[Any], asyncio.StreamReader, asyncio.StreamWriter]:
    """Return our end of a new connection, by the type that it receives, and the streams of the server's end."""
    ours, theirs = socket.socketpair()
    stream: FrameStream[Any] = FrameStream(*await asyncio.open_connection(sock=ours), incoming)
    return (stream, *await asyncio.open_connection(sock=theirs))


async def receive(stream: FrameStream[Any]) -> Any:
    """Return the next frame, which must come soon, or None if the other end closed the connection."""
    async with patience(10.0):
        return await stream.receive()


def hello(container: str, secret: str, pid: int = 42, applied: int = 0) -> robot_link.Hello:
    """Return the first message of a container."""
    return robot_link.Hello(container, secret, pid, applied, HELLO_TOPICS, HELLO_SERVICES, HELLO_NODES)


def register(
    machine: str = "m1",
    secret: str = "secret",
    cores: int = 2,
    carries: tuple[control_link.RunningContainer, ...] = (),
    release: str = __version__,
    epoch: int = 0,
) -> control_link.Register:
    """Return the first message of an agent."""
    return control_link.Register(machine, secret, 1000, cores, 1 << 30, carries=carries, release=release, epoch=epoch)
