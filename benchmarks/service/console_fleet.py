"""Measures the dashboard with a fleet on one map, whose robots move several times a second, in a browser.

Hundreds of containers do not fit on the computer of a bench. So the REST service is the cloud's own, over a control
plane that reports made-up robots, and the robots' WebSockets are answered here, in the frames of an endpoint: the page
cannot see the difference.
"""

import asyncio
import json
import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import psutil
from playwright.async_api import Browser, Page, ViewportSize, expect
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from engine.master.places import robot_key
from engine.protocols.robot_link import ContainerBeat
from engine.specs.robot_report import StateReport
from ppaas.clock import epoch, monotonic
from ppaas.geometry import Pose2D
from ppaas.messages import encode
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped, Twist
from ppaas.messages.ppaas_msgs import RobotStates
from tests.support.cloud.browser import browsing, enter
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.endpoints.fleet import name_of, serving_fleet
from tests.support.endpoints.zones import GRID

DESK = ViewportSize(width=1440, height=900)
RATE = 5.0
"""Rate at which the poses of all robots change [1/s]."""

BEAT = 1.0
"""Time between two reports of a container [s]."""

SECONDS = 15.0
OWNER = "ann"


@dataclass(frozen=True, slots=True)
class Roamer:
    """Robot that drives in circles.

    Parameters
    ----------
    name : str
    x, y, radius : float
        Centre and radius of the circle [m].
    speed : float
        Angular speed [rad/s].
    """

    name: str
    x: float
    y: float
    radius: float
    speed: float

    def pose(self, time: float) -> Pose2D:
        """Return where it is."""
        angle = self.speed * time
        return Pose2D(
            self.x + self.radius * math.cos(angle), self.y + self.radius * math.sin(angle), angle + math.pi / 2
        )

    def report(self, time: float) -> StateReport:
        """Return what its container reports."""
        pose = self.pose(time)
        left = 20.0 - (self.speed * self.radius * time) % 20.0
        return StateReport(
            pose=(pose.x, pose.y, pose.theta), pose_at=epoch(), goal=Status.ACTIVE, left=left,
            battery=1.0 - time % 3600.0 / 3600.0, software="ppaas/0.2.0",
        )  # fmt: skip


def roamers(count: int, width: float, height: float) -> list[Roamer]:
    """Return robots that drive in circles, spread over a map of this size [m]."""
    columns = math.ceil(math.sqrt(count * width / height))
    step = width / columns
    return [
        Roamer(
            name_of(number), (number % columns + 0.5) * step, (number // columns + 0.5) * step, step / 2,
            0.5 + number % 5 / 5,
        )
        for number in range(count)
    ]  # fmt: skip


class Sockets:
    """Application that answers the WebSockets of robots, and hands everything else to another one.

    Parameters
    ----------
    app : ASGIApp
        The application of the cloud.
    robots : sequence of Roamer

    Attributes
    ----------
    opened : int
        Number of sockets that the page has opened.
    """

    def __init__(self, app: ASGIApp, robots: Sequence[Roamer]) -> None:
        self._app = app
        self._robots = {robot.name: robot for robot in robots}
        self.opened = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a connection."""
        if scope["type"] != "websocket":
            await self._app(scope, receive, send)
            return
        socket = WebSocket(scope, receive, send)
        await socket.accept()
        self.opened += 1
        wanted: set[str] = set()
        sending = asyncio.create_task(self._send(socket, self._robots[socket.query_params["robot"]], wanted))
        try:
            while True:
                frame = json.loads(await socket.receive_text())
                if frame["op"] == "subscribe":
                    wanted.add(frame["topic"])
        except WebSocketDisconnect:
            sending.cancel()

    async def _send(self, socket: WebSocket, robot: Roamer, wanted: set[str]) -> None:
        due = monotonic()
        while True:
            if "amcl_pose" in wanted:
                await socket.send_text(_publish("amcl_pose", _localized(robot)))
            if "robots" in wanted:
                await socket.send_text(_publish("robots", self._others(robot)))
            due += 1.0 / RATE
            await asyncio.sleep(max(0.0, due - monotonic()))

    def _others(self, robot: Roamer) -> bytes:
        now = monotonic()
        others = [one for one in self._robots.values() if one is not robot]
        poses = [Pose.of(one.pose(now)) for one in others]
        header = Header(stamp=Time.of(epoch()), frame_id="map")
        radii, names = [0.18] * len(others), [one.name for one in others]
        return encode(RobotStates(header, poses, [Twist()] * len(others), radii, [], names))


def _publish(topic: str, message: bytes) -> str:
    return f'{{"op":"publish","topic":"{topic}","msg":{message.decode()}}}'


def _localized(robot: Roamer) -> bytes:
    header = Header(stamp=Time.of(epoch()), frame_id="map")
    pose = PoseWithCovariance(Pose.of(robot.pose(monotonic())))
    return encode(PoseWithCovarianceStamped(header, pose))


async def report_on(cloud: FakeCloud, robots: Sequence[Roamer]) -> None:
    """Report on robots as their containers do, until cancelled."""
    while True:
        for robot in robots:
            place = cloud.places[robot_key(OWNER, robot.name)]
            place.beat = ContainerBeat(busy=True, sockets=1, robot=True, report=robot.report(monotonic()))
        await asyncio.sleep(BEAT)


# -- what is measured --------------------------------------------------------------------------------------------------

FRAMES = """(ms) => new Promise((done) => {
    const times = [], began = performance.now();
    const look = (now) => { times.push(now); now - began < ms ? requestAnimationFrame(look) : done(times); };
    requestAnimationFrame(look);
})"""
"""Script that returns the times of all frames of the next milliseconds."""

YARDSTICK = """<canvas width=808 height=840></canvas><script>
    const context = document.querySelector("canvas").getContext("2d");
    setInterval(() => {
        context.clearRect(0, 0, 808, 840);
        for (let i = 0; i < COUNT; i++) {
            const x = 400 + 380 * Math.cos(i + performance.now() / 1000), y = 420 + 400 * Math.sin(7 * i);
            context.beginPath();
            context.arc(x, y, 8, 0, 2 * Math.PI);
            context.fill();
            context.fillText("tb" + i, x, y + 20);
        }
    }, 200);
</script>"""
"""Page that draws as many discs with names at the same rate, and does nothing else."""


@dataclass(frozen=True, slots=True)
class PageLoad:
    """Load of a page.

    Parameters
    ----------
    cpu : float
        CPU time of all processes of the browser [cores].
    frame : float
        95th percentile of the time between two frames [ms].
    longest : float
        Longest time between two frames [ms].
    """

    cpu: float
    frame: float
    longest: float

    def __str__(self) -> str:
        """Return it in words."""
        return f"{100 * self.cpu:.0f} % of a core, frames {self.frame:.0f} ms (p95), the longest {self.longest:.0f} ms"


def browser_seconds() -> float:
    """Return the CPU time of all processes of the browser so far [s]."""
    total = 0.0
    for process in psutil.Process().children(recursive=True):
        try:
            if "chrom" in process.name():
                times = process.cpu_times()
                total += times.user + times.system
        except psutil.NoSuchProcess:  # it ended meanwhile
            continue
    return total


async def load_of(page: Page) -> PageLoad:
    """Measure a page: first its CPU time alone, then its frames, which cost CPU time themselves."""
    before, began = browser_seconds(), monotonic()
    await asyncio.sleep(SECONDS)
    cpu = (browser_seconds() - before) / (monotonic() - began)
    gaps = [after - before for before, after in pairwise(await page.evaluate(FRAMES, SECONDS * 1000))]
    return PageLoad(cpu, statistics.quantiles(gaps, n=20)[-1], max(gaps))


async def measure(count: int) -> list[tuple[str, PageLoad]]:
    """Return the loads of the yardstick, of the map with a fleet, and of its table above the map."""
    width, height = GRID.info.shape[1] * GRID.info.resolution, GRID.info.shape[0] * GRID.info.resolution
    robots = roamers(count, width, height)
    served = serving_fleet(count, around=lambda app: Sockets(app, robots))
    async with served as (url, token, cloud), browsing() as browser:
        reporting = asyncio.create_task(report_on(cloud, robots))
        try:
            return [
                ("yardstick", await _of_yardstick(browser, count)),
                *await _of_dashboard(browser, url, token, count),
            ]
        finally:
            reporting.cancel()


async def _of_yardstick(browser: Browser, count: int) -> PageLoad:
    page = await browser.new_page(viewport=DESK)
    await page.set_content(YARDSTICK.replace("COUNT", str(count)))
    load = await load_of(page)
    await page.close()
    return load


async def _of_dashboard(browser: Browser, url: str, token: str, count: int) -> list[tuple[str, PageLoad]]:
    page = await browser.new_page(viewport=DESK)
    await enter(page, url, token)
    await expect(page.locator('#robots .presence[data-presence="online"]')).to_have_count(count, timeout=60_000)
    on_map = await load_of(page)
    await page.get_by_role("button", name="Fleet").click()
    await expect(page.locator("#fleet tbody tr").first).to_be_visible()
    return [("map", on_map), ("table above the map", await load_of(page))]
