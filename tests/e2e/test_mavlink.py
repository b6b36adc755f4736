"""A rover with MAVLink as a robot: a simulated ArduPilot over UDP, driven on a map that is anchored on the Earth."""

import asyncio
import math
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from benchmarks.harness.free_ports import free_ports
from ppaas.geometry import Pose2D
from ppaas.maps.georeference import GeoAnchor
from ppaas.maps.grid import GridMap
from robots import cli
from robots.client.move_base import MoveBaseClient
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from robots.sim.mavlink.body import RoverBody
from robots.sim.mavlink.rover import SimulatedRover
from robots.sim.mavlink.serving import STEP, ServedRover
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

ANCHOR = GeoAnchor(-33.8568, 151.2153, math.radians(40.0))
RADIUS = {"global_costmap": {"robot_radius": 0.2}}


class Served:
    """A simulated rover that drives in a thread of its own."""

    def __init__(self, start: Pose2D, port: int, key: bytes | None = None) -> None:
        heading = math.pi / 2.0 - start.theta - ANCHOR.yaw
        self.rover = SimulatedRover("ardupilot", RoverBody(*ANCHOR.to_earth(start.x, start.y), heading, top_speed=0.6))
        self._served = ServedRover(self.rover, f"udpout:127.0.0.1:{port}", key)
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> "Served":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join()
        self._served.close()

    def _run(self) -> None:
        while not self._end.wait(STEP):
            self._served.pump()

    def pose(self) -> Pose2D:
        """Return where the rover really is on the map."""
        x, y = ANCHOR.to_map(*self.rover.body.place())
        return Pose2D(x, y, math.remainder(math.pi / 2.0 - self.rover.body.heading - ANCHOR.yaw, math.tau))


@contextmanager
def bridge(cloud: RunningCloud, robot: str, port: int, log: Path, *words: str) -> Iterator[None]:
    """Run ``ppaas bridge mavlink``; its log is printed, which pytest shows of a failed test."""
    anchor = f"--anchor={ANCHOR.latitude},{ANCHOR.longitude},{math.degrees(ANCHOR.yaw)}"
    command = [
        sys.executable, "-m", cli.__name__, "bridge", "mavlink", "--robot", robot,
        "--vehicle", f"udpin:127.0.0.1:{port}", anchor, "--url", cloud.url, "--token", str(cloud.token), *words,
    ]  # fmt: skip
    with log.open("ab") as output:
        process = subprocess.Popen(command, stdout=output, stderr=output)
    try:
        yield
    finally:
        process.terminate()
        assert process.wait(10.0) is not None
        sys.stdout.write(log.read_text())


async def registered(cloud: RunningCloud, robot: str, grid: GridMap, parameters: dict[str, Any]) -> None:
    rest = await cloud.admin()
    await publish_map(rest, f"yard-{robot}", grid)
    await rest.put_robot(robot, RobotFile(map=f"yard-{robot}", cores=0.25, parameters={**RADIUS, **parameters}))


WAYPOINTS: dict[str, Any] = {"follow_path": {}}
VELOCITIES: dict[str, Any] = {"amcl": {"localize": False}}


@pytest.mark.parametrize(("robot", "parameters"), [("sailor", WAYPOINTS), ("driver", VELOCITIES)])
async def test_a_rover_drives_to_its_goal_and_is_left_to_a_person_who_takes_it(
    cloud: RunningCloud,
    office_map: GridMap,
    tmp_path: Path,
    robot: str,
    parameters: dict[str, Any],
) -> None:
    await registered(cloud, robot, office_map, parameters)
    start = free_pose(office_map, seed=61)
    goal = reachable_pose(office_map, start, seed=62, at_least=1.0, at_most=2.0)
    (port,), log = free_ports(1), tmp_path / "bridge.log"
    with Served(start, port) as served, bridge(cloud, robot, port, log, "--arm", "--system", "1"):
        assert cloud.token is not None
        async with RobotClient(cloud.url, robot=robot, token=cloud.token, role="operator") as client:
            move_base = await MoveBaseClient(client).start()
            assert (await move_base.localized()).distance_to(start) < 0.05
            outcome = await move_base.go(goal)
            assert outcome.reached, outcome.text
            assert served.pose().distance_to(goal) < 0.5
            assert served.rover.armed
            (shown,) = [each for each in await (await cloud.admin()).items("/v1/robots") if each["id"] == robot]
            assert shown["battery"] == pytest.approx(0.76) and not shown["error"]

            driving = asyncio.create_task(move_base.go(start))
            await until(lambda: served.rover.mode.name in ("AUTO", "GUIDED") and served.rover.body.speed > 0.1, 20.0)
            served.rover.order("mode MANUAL")
            outcome = await driving
            assert not outcome.reached
            assert parameters is VELOCITIES or "switched to MANUAL" in outcome.text
            await asyncio.sleep(1.5)
            assert served.rover.mode.name == "MANUAL"
            assert "switched to MANUAL" in log.read_text()
