"""Clients beside the robots: one that subscribes with throttle rates, and one that requests paths by REST."""

import asyncio
import itertools
import logging
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Protocol

from ppaas.errors import PPaaSError
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.move_base_msgs import MoveBaseActionFeedback
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.sim.courses import Course

logger = logging.getLogger(__name__)

# -- client of a robot that subscribes to its topics with throttle rates, as dashboards and bridges do -----------------

RETRY = 1.0
"""Delay before a client that gave up is replaced [s]."""

THROTTLES = (0.005, 0.017, 0.029, 0.049, 0.051, 0.11, 0.25)
"""Least times between two messages [s]: far below, near and above the period of a control cycle, 0.05 s."""

POSES = "amcl_pose"
"""Topic on which a stamp may come again: a delayed simulation sends several scans with the same one."""

TOPICS: tuple[tuple[str, type[Message]], ...] = (
    ("move_base/feedback", MoveBaseActionFeedback),
    (POSES, PoseWithCovarianceStamped),
)


class StampedMessage(Protocol):
    """A message with a header."""

    header: Header


class ThrottledClient:
    """Subscribes to topics of a robot, each with a throttle rate, and checks that no message is delivered twice.

    Whether it disturbs the robot or other clients is found by their checks.

    Parameters
    ----------
    address : tuple of str
        URL of the cloud, and a token of a user who may see the robot.
    robot : str
        Name of the robot.
    number : int
        Number of the client, by which its throttle rates are chosen.
    tell : callable
        Called with a description of each error.

    Attributes
    ----------
    messages : int
        Number of messages received.
    """

    def __init__(self, address: tuple[str, str], robot: str, number: int, tell: Callable[[str], None]) -> None:
        self._address = address
        self._robot = robot
        self._number = number
        self._tell = tell
        self._newest = dict.fromkeys((topic for topic, _ in TOPICS), 0.0)
        self.messages = 0

    async def run(self) -> None:
        """Stay subscribed until cancelled; a connection that gives up is replaced."""
        url, token = self._address
        while True:
            try:
                async with RobotClient(url, robot=self._robot, token=token, role="operator") as client:
                    for place, (topic, kind) in enumerate(TOPICS):
                        throttle = THROTTLES[(self._number + place) % len(THROTTLES)]
                        await client.subscribe(topic, kind, partial(self.on_message, topic), throttle=throttle)
                    await client.closed()
            except* PPaaSError as errors:
                logger.warning("throttled client of %s: %s", self._robot, errors.exceptions[0])
                await asyncio.sleep(RETRY)

    def on_message(self, topic: str, message: StampedMessage) -> None:
        """Check that a message is newer than the last one of its topic; poses have the stamps of scans."""
        self.messages += 1
        stamp, newest = message.header.stamp.seconds(), self._newest[topic]
        if stamp < newest or (stamp == newest and topic != POSES):
            how = "again" if stamp == newest else f"{newest - stamp:.3f} s older than the last one"
            self._tell(f"throttled client {self._number} of {self._robot} received {topic} {how}")
        self._newest[topic] = max(stamp, newest)

    def check(self) -> None:
        """Report a client that has received nothing from a robot that drove."""
        if not self.messages:
            self._tell(f"throttled client {self._number} of {self._robot} received nothing")


class ThrottledClients:
    """Several throttled clients.

    Parameters
    ----------
    clients : sequence of ThrottledClient
    """

    def __init__(self, clients: Sequence[ThrottledClient]) -> None:
        self._clients = clients

    @property
    def messages(self) -> int:
        """Number of messages that all have received."""
        return sum(client.messages for client in self._clients)

    async def run(self) -> None:
        """Run all until cancelled."""
        await asyncio.gather(*(client.run() for client in self._clients))

    def check(self) -> None:
        """Report those that have received nothing."""
        for client in self._clients:
            client.check()


def clients_of(
    address: tuple[str, str], robots: Iterable[str], count: int, tell: Callable[[str], None]
) -> ThrottledClients:
    """Return ``count`` clients of each robot."""
    return ThrottledClients(
        [ThrottledClient(address, robot, number, tell) for robot in robots for number in range(count)]
    )


# -- client that requests paths by REST, so that containers without a robot run too ------------------------------------

PERIOD = 1.0
"""Period of the requests [s]."""


class PathRequester:
    """Requests paths, and counts the answers: a path, or the code of the error.

    Parameters
    ----------
    rest : RestClient
        Logged in.
    map_id : str
        Id of the map.
    courses : sequence of Course
        Starts and goals of the requested paths.
    """

    def __init__(self, rest: RestClient, map_id: str, courses: Sequence[Course]) -> None:
        self._rest = rest
        self._map = map_id
        self._ways = itertools.cycle([(course.start, goal) for course in courses for goal in course.goals])
        self.answers: Counter[str] = Counter()

    async def run(self) -> None:
        """Request paths until cancelled."""
        for start, goal in self._ways:
            try:
                await self._rest.plan(self._map, start, goal)
                self.answers["path"] += 1
            except PPaaSError as error:
                self.answers[error.slug] += 1
            await asyncio.sleep(PERIOD)
