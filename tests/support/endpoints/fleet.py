"""A fleet of robots that a page shows: a server that has them, and their sockets, which the test answers."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, closing
from typing import Any

from argon2 import PasswordHasher, profiles
from playwright.async_api import Page, WebSocketRoute
from starlette.types import ASGIApp

from endpoints.accounts.accounts import Accounts
from endpoints.accounts.passwords import Passwords
from endpoints.app import create_app
from endpoints.resources.services import Services
from engine.control.robot_stops import RobotStops
from engine.links.place_link import PlaceLink
from engine.master.places import robot_key
from engine.specs.containers import MapVersion
from ppaas.maps.formats.map_files import save_map
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.serving import serve
from tests.support.endpoints.zones import GRID
from tests.support.storage.records import GivenMap, put_map, robot

PERIOD = 0.5
"""Time between two poses of a robot [s]."""


class RobotSockets:
    """Sockets of the robots of a page, which publish what the test says.

    Attributes
    ----------
    open : dict of str to WebSocketRoute
        Open sockets by robot.
    """

    def __init__(self) -> None:
        self.open: dict[str, WebSocketRoute] = {}
        self._poses: dict[str, tuple[float, float]] = {}

    @asynccontextmanager
    async def beating(self) -> AsyncIterator[None]:
        """Repeat the poses of robots that were placed: of one that is silent, pages say so."""
        task = asyncio.create_task(self._beat())
        try:
            yield
        finally:
            task.cancel()

    async def answer(self, page: Page) -> None:
        """Answer all robots' sockets of a page."""
        await page.route_web_socket("**/*ticket=*", self._opened)

    def publish(self, name: str, topic: str, message: dict[str, Any]) -> None:
        """Send a message of a robot to the page."""
        self.open[name].send(json.dumps({"op": "publish", "topic": topic, "msg": message}))

    def place(self, name: str, x: float, y: float) -> None:
        """Say where a robot is, from now on."""
        self._poses[name] = x, y
        self._publish_pose(name, x, y)

    def _publish_pose(self, name: str, x: float, y: float) -> None:
        pose = {"position": {"x": x, "y": y, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}
        header = {"stamp": {"secs": 1, "nsecs": 0}, "frame_id": "map"}
        self.publish(name, "amcl_pose", {"header": header, "pose": {"pose": pose}})

    def status(self, name: str, status: int, text: str = "") -> None:
        """Send the state of a robot's goal, as actionlib has it."""
        goal = {"goal_id": {"id": "g"}, "status": status, "text": text}
        self.publish(name, "move_base/status", {"status_list": [goal]})

    async def _beat(self) -> None:
        while True:
            for name, (x, y) in self._poses.items():
                self._publish_pose(name, x, y)
            await asyncio.sleep(PERIOD)

    def _opened(self, socket: WebSocketRoute) -> None:
        name = socket.url.partition("robot=")[2].partition("&")[0]
        self.open[name] = socket
        socket.on_message(_ignore)


def _ignore(_message: str | bytes) -> None:
    """Take what the page asks a robot: a still robot answers nothing."""


def name_of(number: int) -> str:
    """Return the id of a robot of the fleet."""
    return f"tb{number}"


@asynccontextmanager
async def serving_fleet(
    count: int,
    connected: Callable[[int], bool] = lambda _number: True,
    elsewhere: tuple[str, ...] = (),
    around: Callable[[ASGIApp], ASGIApp] = lambda app: app,
) -> AsyncIterator[tuple[str, str, FakeCloud]]:
    """Serve a fleet of ann, who is an administrator; return the URL, her token and the cloud.

    Parameters
    ----------
    count : int
        Number of her robots, all on the map office.
    connected : callable
        Whether the robot of a number has a container and is connected.
    elsewhere : tuple of str
        Ids of further robots of hers, on the map yard, which are not connected.
    around : callable
        Returns the application to serve in place of the one that it is given.
    """
    store, maps, cloud = MemoryStore(), MemoryMapStore(), FakeCloud()
    cloud.stops = RobotStops(cloud, store)
    accounts = Accounts(store, passwords=Passwords(PasswordHasher.from_parameters(profiles.CHEAPEST), workers=1))
    await accounts.register("ann", "correct horse", "admin")
    yaml, image = save_map(GRID, "office.pgm")
    record = put_map(maps, GivenMap("office", "ann", yaml, image))
    if elsewhere:
        put_map(maps, GivenMap("yard", "ann", yaml, image))
    for name in elsewhere:
        store.put_robot(robot(name, user="ann", map="yard"))
    for number in range(count):
        store.put_robot(robot(name_of(number), user="ann", map="office"))
    version = MapVersion("office", record.version)
    cloud.running = [
        container(f"c{number}", robot=name_of(number), map=version, machine=f"m{number % 2 + 1}", connected=True)
        for number in range(count)
        if connected(number)
    ]
    for one in cloud.running:
        cloud.connect("ann", one.robot or "", PlaceLink(robot_key("ann", one.robot or "")))
    with closing(accounts):
        async with serve(around(create_app(Services(store, maps, accounts, cloud)))) as port:
            yield f"http://127.0.0.1:{port}", await accounts.login("ann", "correct horse"), cloud
