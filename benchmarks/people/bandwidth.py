"""Part ``bandwidth`` of ``ppaas bench people``: bytes on a robot's link with ``torso_detector`` in both homes.

A simulated robot with a depth camera is connected to a cloud of its own through a proxy that counts bytes. Its traffic
without images, as scans and odometry, is measured first and subtracted.
"""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import NamedTuple
from urllib.parse import urlsplit

import numpy as np

from benchmarks.harness.cloud_under_test import CloudUnderTest, own_cloud
from benchmarks.harness.figures import Figure, PartResult
from benchmarks.people.options import PeopleOptions
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from ppaas.messages.people_msgs import PositionMeasurementArray
from ppaas.messages.ppaas_msgs import NodeHomes
from ppaas.nodes.topics import TORSO_MEASUREMENTS
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from robots.demo.exploration import background
from robots.demo.people_world import WALKERS
from robots.onboard.computer import this_computer
from robots.onboard.local_nodes import run_local_nodes
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.driver import Driver, SensorRates
from robots.sim.robot import SimulatedRobotModel
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.simulator import Simulator
from robots.sim.world import World

PART = "bandwidth"
NODE = "torso_detector"
SHARE = 1.0 / 20.0
"""Bar of the link that the node on the robot uses, as a share of raw images."""

RATE = 5.0
"""Rate of images [Hz]."""

SECONDS, QUICK_SECONDS, SETTLING = 20.0, 5.0, 3.0
"""Length of a measurement, usually and if few samples are taken, and time before it [s]."""

READY_TIMEOUT = 60.0
"""Time limit until the node is at home [s]."""

PEOPLE = 3


class BandwidthCase(NamedTuple):
    """Kind of images and home of the node; without images, the robot has no camera."""

    name: str
    images: bool
    compressed: bool
    home: str


CASES = (
    BandwidthCase("no images", images=False, compressed=True, home="cloud"),
    BandwidthCase("raw images, node in the cloud", images=True, compressed=False, home="cloud"),
    BandwidthCase("compressed images, node in the cloud", images=True, compressed=True, home="cloud"),
    BandwidthCase("node on the robot", images=True, compressed=False, home="robot"),
)


class ByteRates(NamedTuple):
    """Bytes per second from the robot to the cloud, and back; and images per second that the node has processed."""

    up: float
    down: float
    processed: float


class CountingProxy:
    """Proxy of one TCP port that counts bytes.

    Attributes
    ----------
    up, down : int
        Bytes from clients, and to them.
    """

    def __init__(self, host: str, port: int) -> None:
        self.up = self.down = 0
        self._host, self._port = host, port
        self._tasks = set[asyncio.Task[None]]()

    @contextlib.asynccontextmanager
    async def serve(self) -> AsyncIterator[str]:
        """Listen during the block; yield the base URL for clients."""
        server = await asyncio.start_server(self._connected, "127.0.0.1", 0)
        try:
            yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
        finally:
            server.close()
            for task in self._tasks:
                task.cancel()
            await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._tasks.add(task)
        try:
            cloud_reader, cloud_writer = await asyncio.open_connection(self._host, self._port)
            async with asyncio.TaskGroup() as group:
                group.create_task(self._copy(reader, cloud_writer, up=True))
                group.create_task(self._copy(cloud_reader, writer, up=False))
        finally:
            self._tasks.discard(task)

    async def _copy(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, *, up: bool) -> None:
        with contextlib.suppress(ConnectionError):
            while data := await reader.read(1 << 16):
                if up:
                    self.up += len(data)
                else:
                    self.down += len(data)
                writer.write(data)
                await writer.drain()
        writer.close()


def measure(options: PeopleOptions) -> PartResult:
    """Return the traffic of each case, and the share of the link that the node on the robot uses."""
    found = asyncio.run(_measure_all(options))
    rest = found[CASES[0]]
    own = {
        case: ByteRates(each.up - rest.up, each.down - rest.down, each.processed)
        for case, each in found.items()
        if case.images
    }
    raw, local = own[CASES[1]], own[CASES[3]]
    share = (local.up + local.down) / (raw.up + raw.down)
    size = f"{DepthCameraModel().width}×{DepthCameraModel().height}"
    figures = [
        Figure(
            PART, case.name, round((each.up + each.down) / 1e3, 3), "KB/s", note=f"up and down; {size} at {RATE:g} Hz"
        )
        for case, each in own.items()
    ]
    figures.append(Figure(PART, "node on the robot ÷ raw images", round(share, 5), "", limit=SHARE))
    rows = [_row(case.name, each) for case, each in own.items()]
    rows.append(_row("the rest: scans, odometry, commands", rest))
    results = [{"case": case.name, **each._asdict()} for case, each in found.items()]
    return PartResult(figures, rows, results)


def _row(name: str, traffic: ByteRates) -> dict[str, str]:
    return {
        "traffic of": name,
        "to the cloud": f"{traffic.up / 1e3:,.1f} KB/s",
        "to the robot": f"{traffic.down / 1e3:,.1f} KB/s",
        "images processed": f"{traffic.processed:.1f} Hz",
    }


async def _measure_all(options: PeopleOptions) -> dict[BandwidthCase, ByteRates]:
    async with own_cloud() as target:
        grid = office(options.seed, 14.0, 11.0)
        await target.publish("office", grid)
        address = urlsplit(target.url)
        assert address.hostname is not None
        assert address.port is not None
        proxy = CountingProxy(address.hostname, address.port)
        async with proxy.serve() as url:
            return {case: await _measure(target, proxy, url, case, options) for case in CASES}


async def _measure(
    target: CloudUnderTest, proxy: CountingProxy, url: str, case: BandwidthCase, options: PeopleOptions
) -> ByteRates:
    world = _world(options.seed, camera=case.images)
    body, name = world.robots[0], f"{PART}-{CASES.index(case)}"
    pose = (body.base.pose.x, body.base.pose.y, body.base.pose.theta)
    await target.rest.put_robot(name, RobotFile(map="office", initial_pose=pose, parameters={NODE: {}}))
    async with contextlib.AsyncExitStack() as stack:
        await stack.enter_async_context(background(Simulator(world).run()))
        client = await stack.enter_async_context(RobotClient(url, robot=name, token=target.token))
        homes = _Homes()
        await client.subscribe("node_monitor/homes", NodeHomes, homes.changed)
        driver = Driver(body, client, SensorRates(depth=RATE), compressed=case.compressed)
        await stack.enter_async_context(background(driver.run()))
        if case.home == "robot":
            computer = await asyncio.to_thread(this_computer)
            await stack.enter_async_context(
                background(run_local_nodes(client, computer, {NODE: case.home}, lambda _: None))
            )
            await homes.wait_for(case.home)
        # Not through the proxy.
        operator = await stack.enter_async_context(
            RobotClient(target.url, robot=name, token=target.token, role="operator")
        )
        stamps = list[float]()
        await operator.subscribe(
            TORSO_MEASUREMENTS.name, PositionMeasurementArray, lambda found: stamps.append(found.header.stamp.seconds())
        )
        await asyncio.sleep(SETTLING)
        seconds = QUICK_SECONDS if options.quick else SECONDS
        up, down, before = proxy.up, proxy.down, len(stamps)
        await asyncio.sleep(seconds)
        return ByteRates((proxy.up - up) / seconds, (proxy.down - down) / seconds, (len(stamps) - before) / seconds)


class _Homes:
    """Homes of the robot's nodes, as the node monitor reports them."""

    def __init__(self) -> None:
        self._homes: dict[str, str] = {}
        self._changed = asyncio.Event()

    def changed(self, message: NodeHomes) -> None:
        self._homes |= {home.node: home.home for home in message.nodes}
        self._changed.set()

    async def wait_for(self, home: str) -> None:
        try:
            async with asyncio.timeout(READY_TIMEOUT):
                while self._homes.get(NODE) != home:
                    self._changed.clear()
                    await self._changed.wait()
        except TimeoutError:
            raise Unavailable(
                f"{NODE} did not move to the robot within {READY_TIMEOUT:g} s: run the bench on a computer with less "
                "load"
            ) from None


def _world(seed: int, *, camera: bool) -> World:
    grid, rng = office(seed, 14.0, 11.0), np.random.default_rng(seed)
    world = World(grid, seed, bodies=True)
    world.pedestrian_model = WALKERS
    ways = ShortestPaths(grid, 0.4, rng)
    start: Pose2D = ways.anywhere()
    world.add_robot(start, SimulatedRobotModel(camera=DepthCameraModel() if camera else None))
    for _ in range(PEOPLE):
        world.add_pedestrian(ways, ways.away_from(start, 1.5))
    return world
