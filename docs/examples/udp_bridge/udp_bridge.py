"""A custom bridge: a robot sends its odometry as JSON in UDP datagrams, and gets its velocities in the same way."""

import argparse
import asyncio
import logging

import msgspec

from ppaas.decoding import from_json
from ppaas.geometry import Pose2D
from ppaas.log_lines import log_lines
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance, Vector3
from ppaas.messages.nav_msgs import Odometry
from robots.cli import event_loop
from robots.cli.session import add_cloud_arguments, token_of
from robots.client import RobotClient

HELP = "connect a robot that sends its odometry as JSON in UDP datagrams"
Reading = tuple[float, float, float, float, float]  # x, y [m], yaw [rad], speeds [m/s, rad/s]


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="id of the robot, as registered by 'ppaas robot put'")
    add_cloud_arguments(parser)
    parser.add_argument("--host", default="127.0.0.1", help="address of this computer on which to listen (%(default)s)")
    parser.add_argument("--port", type=int, default=8600, help="port on which to listen (%(default)s)")


def run(arguments: argparse.Namespace) -> int:
    log_lines("%(levelname)s %(message)s", level=logging.INFO)
    event_loop.run(carry(arguments))
    return 0


class Link(asyncio.DatagramProtocol):
    def __init__(self) -> None:
        self.readings: asyncio.Queue[tuple[Reading, tuple[str, int]]] = asyncio.Queue(maxsize=100)

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        try:
            self.readings.put_nowait((from_json(data, Reading), addr))
        except (msgspec.DecodeError, asyncio.QueueFull) as error:
            logging.warning("a datagram of %s is dropped: %r", addr, error)


async def carry(arguments: argparse.Namespace) -> None:
    where = arguments.host, arguments.port
    async with RobotClient(arguments.url, robot=arguments.robot, token=token_of(arguments)) as cloud:
        transport, link = await asyncio.get_running_loop().create_datagram_endpoint(Link, local_addr=where)
        logging.info("listening on %s:%d", *where)
        (x, y, yaw, v, w), robot = await link.readings.get()  # the robot speaks first: before, its address is unknown
        send = lambda twist: transport.sendto(msgspec.json.encode([twist.linear.x, twist.angular.z]), robot)  # noqa: E731
        await cloud.subscribe("cmd_vel", Twist, send, queue_size=1)
        while True:
            pose, twist = Pose.of(Pose2D(x, y, yaw)), Twist(Vector3(x=v), Vector3(z=w))
            odom = Odometry(Header(frame_id="odom"), "base_link", PoseWithCovariance(pose), TwistWithCovariance(twist))
            await cloud.publish("odom", odom, newest_only=True)
            (x, y, yaw, v, w), robot = await link.readings.get()
