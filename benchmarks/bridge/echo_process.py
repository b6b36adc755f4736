"""Process of a node of ROS that sends each scan back: the stack's own echo, without a bridge and a cloud.

``python -m benchmarks.bridge.echo_process TRANSPORT ENDPOINT`` runs until it is terminated.
"""

import asyncio
import os
import sys

from ppaas.wire.ros.graph import SENSOR
from robots.bridges.core.transport import Transport
from robots.bridges.dds.node import DdsOptions, DdsTransport
from robots.bridges.ros1.node import Ros1Options, Ros1Transport
from robots.bridges.zenoh.node import ZenohOptions, ZenohTransport

SCAN, TO, BACK = "sensor_msgs/msg/LaserScan", "/echo/scan", "/echo/back"

DOMAIN = 87
"""Domain that no robot here has."""


def node(name: str, endpoint: str, title: str) -> Transport:
    """Return a node of a transport, given the endpoint of a router or the URI of a master; over DDS it stays here."""
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    if name == "dds":
        return DdsTransport(DdsOptions(DOMAIN, "jazzy"), title)
    if name == "ros1":
        return Ros1Transport(Ros1Options(endpoint), title)
    return ZenohTransport(ZenohOptions(connect=(endpoint,), domain=DOMAIN, release="jazzy"), title)


async def _run(name: str, endpoint: str) -> None:
    echo = node(name, endpoint, "echo")
    await echo.open(lambda: None)
    back = echo.publisher(BACK, SCAN, SENSOR)
    subscription = echo.subscribe(TO, SCAN, SENSOR, back.publish)
    try:
        await asyncio.Event().wait()
    finally:
        subscription.close()
        await echo.close()


if __name__ == "__main__":
    asyncio.run(_run(sys.argv[1], sys.argv[2]))
