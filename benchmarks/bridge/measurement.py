"""Messages through a bridge in its own process, between a node of ROS and a stand-in for the cloud.

Node and stand-in are in this process and share its clock. The baseline is half of the time that a scan takes to a
second node in another process and back, without the bridge.
"""

import asyncio
import os
import subprocess
import sys
from collections import defaultdict
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

import msgspec
import psutil
from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response

from benchmarks.bridge import master_stand_in
from benchmarks.bridge.echo_process import BACK, DOMAIN, SCAN, TO, node
from benchmarks.harness.figures import Figure, median_of
from benchmarks.harness.free_ports import free_ports
from benchmarks.harness.process_usage import cpu_of
from ppaas.clock import monotonic
from ppaas.messages.base.spelling import split_json
from ppaas.wire.ros.graph import LATCHED, SENSOR, Qos
from robots import cli
from robots.bridges.core.transport import Transport

if TYPE_CHECKING:
    from rich.progress import Progress


TOPICS = ["/odom", "/scan", "/tf", "/tf_static", "/goal_pose", "/initialpose"]
"""Topics that the stand-in's clone has."""


MAX_PARTS = 16
"""Largest number of operations in a frame."""

GOAL = {"id": "goal", "pose": [1.0, 2.0, 0.5], "state": "active", "text": "", "sent": 1.0, "ended": None}
ROBOT = {"id": "robot", "map": "map", "model": "turtlebot2", "parameters": dict[str, Any]()}
"""Goal and robot that the stand-in knows, as REST has them."""


class _Frame(msgspec.Struct):
    op: str
    id: str | None = None
    topic: str = ""
    service: str = ""


class CloudStandIn:
    """Server for one bridge, with a connection for each of its robots.

    Attributes
    ----------
    arrived : dict
        Times at which messages arrived, by topic [s].
    """

    def __init__(self) -> None:
        self.url = ""
        self.arrived: defaultdict[str, list[float]] = defaultdict(list)
        self.subscribed: set[str] = set()
        self._sockets: set[ServerConnection] = set()
        self._decoder = msgspec.json.Decoder(_Frame)

    async def handle(self, socket: ServerConnection) -> None:
        """Serve a bridge."""
        self._sockets.add(socket)
        try:
            async for text in socket:
                now = monotonic()
                for part in split_json(text, MAX_PARTS):
                    await self._take(self._decoder.decode(part), now, socket)
        finally:
            self._sockets.discard(socket)

    async def _take(self, frame: _Frame, now: float, socket: ServerConnection) -> None:
        if frame.op == "publish":
            self.arrived[frame.topic].append(now)
        elif frame.op == "subscribe":
            self.subscribed.add(frame.topic)
        elif frame.op == "call_service":
            values = {"topics": TOPICS, "types": []}
            answer = {"op": "service_response", "service": frame.service, "id": frame.id, "result": True}
            await socket.send(msgspec.json.encode(answer | {"values": values}).decode())

    async def send(self, **frame: Any) -> None:
        """Send a frame to the bridge, on each of its connections."""
        assert self._sockets
        text = msgspec.json.encode(frame).decode()
        for socket in list(self._sockets):
            await socket.send(text)

    async def publish(self, topic: str, message: Any) -> None:
        """Publish a message once the bridge has subscribed to the topic."""
        async with asyncio.timeout(20.0):
            while topic not in self.subscribed:  # noqa: ASYNC110 - one wait before a measurement
                await asyncio.sleep(0.01)
        await self.send(op="publish", topic=topic, msg=message)


def _answer(connection: ServerConnection, request: Request) -> Response | None:
    """Answer a request of REST about a robot or a goal; leave WebSockets alone."""
    if "Upgrade" in request.headers:
        return None
    record = GOAL if "/goals/" in request.path else ROBOT
    answer = connection.respond(HTTPStatus.OK, msgspec.json.encode(record).decode())
    answer.headers["Content-Type"] = "application/json"
    return answer


@asynccontextmanager
async def cloud_stand_in() -> AsyncIterator[CloudStandIn]:
    """Run a stand-in on a free port of the loopback interface."""
    cloud = CloudStandIn()
    async with serve(cloud.handle, "127.0.0.1", 0, compression=None, max_size=None, process_request=_answer) as server:
        cloud.url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
        yield cloud


ODOMETRY, TF = "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
TWIST, GRID = "geometry_msgs/msg/Twist", "nav_msgs/msg/OccupancyGrid"
BEAMS, CELLS = 360, 240 * 240
SAMPLES, QUICK_SAMPLES = 300, 20
"""Numbers of scans and of velocities."""

LOAD_SECONDS, QUICK_LOAD_SECONDS = 20.0, 2.0
"""Time for which the robot publishes at full rate while CPU time is counted [s]."""

SCAN_RATE, ODOMETRY_RATE = 10, 50
"""Rates of the load [Hz]; tf has that of odometry."""

MOST_ADDED, MOST_CPU, MOST_MEMORY, MOST_DISCOVERY = 1.0, 5.0, 60.0, 1000.0
"""Limits: added latency [ms], share of a core [%], memory [MB], discovery and late map [ms]."""


async def measure(progress: "Progress", transports: Sequence[str], *, quick: bool) -> list[Figure]:
    """Return the figures of all transports."""
    figures: list[Figure] = []
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"  # for the bridge
    for name in progress.track(transports, description="bridges"):
        async with cloud_stand_in() as cloud:
            figures += await _measure(name, cloud, quick)
    return figures


async def _measure(name: str, cloud: CloudStandIn, quick: bool) -> list[Figure]:
    with _meeting_place(name) as endpoint:
        command = [
            sys.executable,
            "-m",
            cli.__name__,
            "bridge",
            *_words(name, endpoint),
            "--url",
            cloud.url,
            "--token",
            "t",
        ]
        process = await asyncio.to_thread(subprocess.Popen, command, stderr=subprocess.DEVNULL)
        try:
            async with asyncio.timeout(30.0):
                while "cmd_vel" not in cloud.subscribed:  # noqa: ASYNC110 - one wait before a measurement
                    await asyncio.sleep(0.05)
            robot = node(name, endpoint, "robot")
            await robot.open(lambda: None)
            try:
                return await _Robot(name, endpoint, robot, cloud, psutil.Process(process.pid)).measure(quick)
            finally:
                await robot.close()
        finally:
            process.terminate()
            await asyncio.to_thread(process.wait)


@contextmanager
def _meeting_place(name: str) -> Iterator[str]:
    """Yield the endpoint of the router that the bridge is, or the URI of a master that runs in a process of its own."""
    if name != "ros1":
        yield f"tcp/127.0.0.1:{free_ports(1)[0]}"
        return
    [port] = free_ports(1)
    process = subprocess.Popen([sys.executable, "-m", master_stand_in.__name__, str(port)])
    try:
        yield f"http://127.0.0.1:{port}"
    finally:
        process.terminate()
        process.wait()


def _words(name: str, endpoint: str) -> list[str]:
    """Return the bridge's part of the command line."""
    if name == "ros1":
        return ["ros1", "robot", "--master", endpoint]
    listen = ["--listen", endpoint] if name == "zenoh" else []
    return ["ros2", "robot", "--transport", name, "--domain", str(DOMAIN), *listen]


class _Robot:
    """Node of a robot, and the measurements."""

    def __init__(self, name: str, endpoint: str, node: Transport, cloud: CloudStandIn, bridge: psutil.Process) -> None:
        self._name, self._endpoint, self._node = name, endpoint, node
        self._cloud, self._bridge = cloud, bridge
        encode = node.types.encode
        header = {"frame_id": "base_link"}
        self._scan = encode(SCAN, {"header": header, "ranges": [1.234 + beam / 1000 for beam in range(BEAMS)]})
        self._odometry = encode(ODOMETRY, {"header": {"frame_id": "odom"}, "child_frame_id": "base_link"})
        moved = {"header": {"frame_id": "odom"}, "child_frame_id": "base_link", "transform": {}}
        self._tf = encode(TF, {"transforms": [moved]})
        self._velocities: list[float] = []
        node.subscribe("/cmd_vel", TWIST, Qos(), lambda _: self._velocities.append(monotonic()))

    async def measure(self, quick: bool) -> list[Figure]:
        """Return all figures of a transport."""
        began = monotonic()
        odometry = self._node.publisher("/odom", ODOMETRY, Qos())
        scans = self._node.publisher("/scan", SCAN, SENSOR)
        transforms = self._node.publisher("/tf", TF, Qos(depth=100))
        async with asyncio.timeout(30.0):
            while not self._cloud.arrived["odom"] or not self._cloud.arrived["scan"]:
                odometry.publish(self._odometry)
                scans.publish(self._scan)
                await asyncio.sleep(0.01)
        discovery = monotonic() - began
        count = QUICK_SAMPLES if quick else SAMPLES
        direct = await self._direct(count)
        up = await self._samples(count, self._cloud.arrived["scan"], _later(scans.publish, self._scan))
        command = {"linear": {"x": 0.1}, "angular": {"z": 0.1}}
        down = await self._samples(count, self._velocities, lambda: self._cloud.publish("cmd_vel", command))
        share = await self._load(odometry.publish, scans.publish, transforms.publish, quick)
        late = await self._late_map()
        memory = self._bridge.memory_info().rss / 1e6
        part, added = f"bridge {self._name}", MOST_ADDED + 1e3 * sorted(direct)[len(direct) // 2]
        return [
            median_of(part, "scan from node to node, without the bridge", direct, yardstick=True),
            median_of(part, "scan from robot to cloud", up, limit=round(added, 3), note="the baseline and 1 ms"),
            median_of(part, "cmd_vel from cloud to robot", down, limit=round(added, 3), note="the baseline and 1 ms"),
            Figure(part, "share of a core", round(share, 2), "%", limit=MOST_CPU,
                   note=f"{SCAN_RATE} Hz scans, {ODOMETRY_RATE} Hz odometry and tf"),
            Figure(part, "memory", round(memory, 1), "MB", limit=MOST_MEMORY),
            Figure(part, "first messages of a robot", round(1e3 * discovery, 1), "ms", limit=MOST_DISCOVERY),
            Figure(part, "map of a late subscriber", round(1e3 * late, 1), "ms", limit=MOST_DISCOVERY),
        ]  # fmt: skip

    async def _direct(self, count: int) -> list[float]:
        """Return half of the times of scans to the echo and back, without the bridge [s]."""
        heard: list[float] = []
        self._node.subscribe(BACK, SCAN, SENSOR, lambda _: heard.append(monotonic()))
        publisher = self._node.publisher(TO, SCAN, SENSOR)
        command = [sys.executable, "-m", "benchmarks.bridge.echo_process", self._name, self._endpoint]
        echo = await asyncio.to_thread(subprocess.Popen, command, stderr=subprocess.DEVNULL)
        try:
            async with asyncio.timeout(30.0):
                while not heard:
                    publisher.publish(self._scan)
                    await asyncio.sleep(0.05)
            return [taken / 2 for taken in await self._samples(count, heard, _later(publisher.publish, self._scan))]
        finally:
            echo.terminate()
            await asyncio.to_thread(echo.wait)
            publisher.close()

    async def _samples(self, count: int, arrived: list[float], publish: Callable[[], Awaitable[None]]) -> list[float]:
        """Return the times from publishing messages to their arrival, one after the other [s]."""
        await asyncio.sleep(0.3)
        taken = []
        for _ in range(count):
            before, began = len(arrived), monotonic()
            await publish()
            async with asyncio.timeout(5.0):
                while len(arrived) == before:  # noqa: ASYNC110 - an event would add to what is measured
                    await asyncio.sleep(0)
            taken.append(arrived[before] - began)
            await asyncio.sleep(0.005)
        return taken

    async def _load(self, odometry: Any, scans: Any, transforms: Any, quick: bool) -> float:
        """Return the share of a core that the bridge takes at the rates of a robot [%]."""
        seconds = QUICK_LOAD_SECONDS if quick else LOAD_SECONDS
        used, began = cpu_of(self._bridge), monotonic()
        for tick in range(round(seconds * ODOMETRY_RATE)):
            odometry(self._odometry)
            transforms(self._tf)
            if tick % (ODOMETRY_RATE // SCAN_RATE) == 0:
                scans(self._scan)
            await asyncio.sleep(max(began + (tick + 1) / ODOMETRY_RATE - monotonic(), 0.0))
        return 100.0 * (cpu_of(self._bridge) - used) / (monotonic() - began)

    async def _late_map(self) -> float:
        """Return the time from a subscription to a map that was published before to its arrival [s]."""
        info = {"width": 240, "height": CELLS // 240, "resolution": 0.05}
        await self._cloud.publish("map", {"header": {}, "info": info, "data": [0] * CELLS})
        await asyncio.sleep(0.5)
        heard: list[float] = []
        began = monotonic()
        self._node.subscribe("/map", GRID, LATCHED, lambda _: heard.append(monotonic()))
        async with asyncio.timeout(10.0):
            while not heard:  # noqa: ASYNC110 - likewise
                await asyncio.sleep(0.001)
        return heard[0] - began


def _later(publish: Callable[[bytes], None], data: bytes) -> Callable[[], Awaitable[None]]:
    async def published() -> None:
        publish(data)

    return published
