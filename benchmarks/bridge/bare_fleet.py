"""Program: a node of ROS 2 that publishes the states of a fleet, without robots behind them.

``python -m benchmarks.bridge.bare_fleet ENDPOINT ROBOTS RATE`` runs until it is terminated.
"""

import asyncio
import sys

from benchmarks.bridge.echo_process import node
from ppaas.clock import epoch, monotonic
from ppaas.geometry import Pose2D
from ppaas.wire.rmf.fleet_robot import FleetRobot
from ppaas.wire.rmf.level_frame import LevelFrame
from ppaas.wire.ros.rmf_definitions import FLEET_STATE
from robots.bridges.rmf.fleet import QOS, STATES


async def _run(endpoint: str, count: int, rate: float) -> None:
    bare = node("zenoh", endpoint, "fleet")
    await bare.open(lambda: None)
    states = bare.publisher(STATES, FLEET_STATE, QOS)
    robots = [FleetRobot(f"robot{number}", "turtlebot2", "map", LevelFrame()) for number in range(count)]
    for robot in robots:
        robot.pose = Pose2D(1.0, 2.0, 0.5)
    due = monotonic()
    while True:
        stamp = {"sec": int(epoch()), "nanosec": 0}
        message = {"name": "carts", "robots": [robot.state(stamp) for robot in robots]}
        states.publish(bare.types.encode(FLEET_STATE, message))
        due += 1.0 / rate
        await asyncio.sleep(max(due - monotonic(), 0.0))


if __name__ == "__main__":
    asyncio.run(_run(sys.argv[1], int(sys.argv[2]), float(sys.argv[3])))
