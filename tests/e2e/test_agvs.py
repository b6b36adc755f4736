"""AGVs of other makers as robots: the virtual AGV of vda-5050-lib obeys the cloud over mosquitto."""

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path

import pytest
from aiomqtt import Client

from ppaas.clock import epoch
from ppaas.errors import NotFound, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import encode
from ppaas.wire.vda5050.fields import Fields
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.states import Connection, ConnectionState
from ppaas.wire.vda5050.topics import AgvAddress, Version
from robots import cli
from robots.client.cloud_url import path_of
from robots.client.move_base import MoveBaseClient
from robots.client.robot_client import RobotClient
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.vda5050.mosquitto import Mosquitto
from tests.support.vda5050.simple_agv import SimpleAgv
from tests.support.waiting import patience
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

FOLDER = Path(__file__).parent / "vda5050"
LOGIN = "hall", "a secret of the hall"
AWAY: tuple[ConnectionState, ...] = ("OFFLINE", "HIBERNATING", "CONNECTION_BROKEN")
AGV = {"manufacturer": "acme", "serialNumber": "fork-7"}


class Bridge:
    """Process of ``ppaas bridge agv``, which a test may kill and start again."""

    def __init__(self, cloud: RunningCloud, broker: Mosquitto, log: Path) -> None:
        self._cloud, self._broker, self.log = cloud, broker, log
        self.process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Start the bridge."""
        command = [
            sys.executable, "-m", cli.__name__, "bridge", "agv", "--broker", self._broker.url,
            "--url", self._cloud.url, "--token", str(self._cloud.token), "--map", "hall-1=agv_hall", "--base", "4",
        ]  # fmt: skip
        with self.log.open("ab") as output:
            environment = os.environ | {"PPAAS_MQTT_PASSWORD": LOGIN[1]}
            self.process = subprocess.Popen(command, stdout=output, stderr=output, env=environment)

    def kill(self) -> None:
        """Kill the bridge."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()

    def count(self, words: str) -> int:
        """Return how often the log contains some words."""
        return self.log.read_text().count(words)


@contextmanager
def virtual_agv(node: str, broker: Mosquitto, start: Pose2D, log: Path, speed: float = 0.7) -> Iterator[None]:
    """Run the virtual AGV."""
    told = {
        "transport": {"brokerUrl": broker.url.replace("hall@", ""), "username": LOGIN[0], "password": LOGIN[1]},
        "agv": AGV,
        "position": {"x": start.x, "y": start.y, "theta": start.theta, "mapId": "hall-1"},
        "speed": speed,
    }
    with log.open("ab") as output:
        process = subprocess.Popen([node, "agv.mjs", json.dumps(told)], cwd=FOLDER, stdout=output, stderr=output)
    try:
        yield
    finally:
        process.kill()
        process.wait()


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Mosquitto]:
    """Return a broker with a password."""
    running = Mosquitto(tmp_path, LOGIN)
    running.start()
    yield running
    running.kill()


@pytest.fixture
def bridge(cloud: RunningCloud, broker: Mosquitto, tmp_path: Path) -> Iterator[Bridge]:
    """Return a bridge, killed at the end; its log is printed, which pytest shows of a failed test."""
    made = Bridge(cloud, broker, tmp_path / "bridge.log")
    yield made
    made.kill()
    sys.stdout.write(made.log.read_text() if made.log.exists() else "")


@asynccontextmanager
async def operator(cloud: RunningCloud) -> AsyncIterator[MoveBaseClient]:
    """Be an operator of the robot as soon as the AGV is registered."""
    assert cloud.token is not None
    rest = await cloud.admin()
    async with patience(30.0):
        while True:
            try:
                await rest.get(path_of("robots", AGV["serialNumber"]))
                break
            except PPaaSError:
                await asyncio.sleep(0.2)
    async with RobotClient(cloud.url, robot=AGV["serialNumber"], token=cloud.token, role="operator") as client:
        move_base = await MoveBaseClient(client).start()
        await move_base.localized()
        yield move_base


async def until(condition, seconds: float = 30.0) -> None:
    """Wait until a condition holds."""
    async with asyncio.timeout(seconds):
        while not condition():
            await asyncio.sleep(0.1)


async def test_the_virtual_agv_of_vda_5050_lib_obeys_the_cloud(
    node: str, cloud: RunningCloud, office_map: GridMap, broker: Mosquitto, bridge: Bridge, tmp_path: Path
) -> None:
    if not (FOLDER / "node_modules" / "vda-5050-lib").is_dir():
        pytest.skip("vda-5050-lib is not installed: install Node 20 or newer and run make test")
    rest = await cloud.admin()
    await publish_map(rest, "agv_hall", office_map)
    start = free_pose(office_map, seed=61)
    far = reachable_pose(office_map, start, seed=62, at_least=5.0)
    bridge.start()
    with virtual_agv(node, broker, start, tmp_path / "agv.log"):
        async with operator(cloud) as move_base:
            robot = await rest.get(path_of("robots", AGV["serialNumber"]))
            assert robot["map"] == "agv_hall" and robot["parameters"]["follow_path"] == {}
            estimate = await move_base.localized()
            assert estimate.distance_to(start) < 0.1

            outcome = await move_base.go(far)
            assert outcome.reached, outcome.text
            assert move_base.estimate is not None and move_base.estimate.distance_to(far) < 0.5
            assert bridge.count("update 1,") >= 1, "the route was released in several messages"

            driving = asyncio.create_task(move_base.go(start))
            await until(lambda: move_base.estimate is not None and move_base.estimate.distance_to(far) > 1.0)
            await move_base.cancel()
            assert (await driving).status is Status.PREEMPTED
            await until(lambda: bridge.count("cancelOrder") == 1)

            # The broker is killed and comes back while the AGV drives.
            driving = asyncio.create_task(move_base.go(start))
            await until(lambda: bridge.count("update 0,") == 3)
            broker.kill()
            await asyncio.sleep(1.0)
            broker.start()
            outcome = await driving
            assert outcome.reached, outcome.text

            # The bridge is killed and comes back: it takes up the order of before.
            driving = asyncio.create_task(move_base.go(far))
            await until(lambda: bridge.count("update 0,") == 4)
            await until(lambda: move_base.estimate is not None and move_base.estimate.distance_to(start) > 1.0)
            bridge.kill()
            bridge.start()
            outcome = await driving
            assert outcome.reached, outcome.text
            assert bridge.count("update 0,") == 4, "no order was sent twice"
            assert bridge.count("cancelOrder") == 1
            assert "contradicts" not in bridge.log.read_text()


async def test_the_robot_of_an_agv_is_connected_while_its_agv_is(
    cloud: RunningCloud, office_map: GridMap, broker: Mosquitto, bridge: Bridge
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "agv_hall", office_map)
    bridge.start()
    agv = SimpleAgv(free_pose(office_map, seed=61), map_id="hall-1")
    address = AgvAddress.of(Version.V3_0, AGV["manufacturer"], "truck-1")
    headers = HeaderCounter(Version.V3_0, address)

    async def connected() -> bool:
        try:
            return bool((await rest.get(path_of("robots", "truck-1", "state")))["connected"])
        except NotFound:
            return False

    async with Client("127.0.0.1", broker.port, username=LOGIN[0], password=LOGIN[1]) as client:

        async def say(topic: str, body: Fields) -> None:
            payload = encode(topic, headers.next(topic, epoch()), body, Version.V3_0)
            await client.publish(address.topic(topic), payload, qos=1)

        async def becomes(wanted: ConnectionState, *, here: bool) -> None:
            async with patience(60.0):
                await say(topics.CONNECTION, Connection(connection_state=wanted))
                while await connected() != here:
                    if wanted == "ONLINE":
                        await say(topics.STATE, agv.state())
                    await asyncio.sleep(0.3)

        for away in AWAY:
            await becomes("ONLINE", here=True)
            await becomes(away, here=False)
