"""Latch through which the velocities of local nodes pass to the base: zero while the robot is stopped.

The clone has a latch for all that it sends. What local nodes command never leaves the robot, so it passes this one.
"""

import asyncio
import logging

import msgspec

from ppaas.errors import PPaaSError
from ppaas.messages import encode
from ppaas.messages.geometry_msgs import Twist
from ppaas.messages.health.stops import StopState
from ppaas.nodes.topics import CMD_VEL, STOP_STATE
from robots.client.robot_client import RobotClient
from robots.client.subscription import TopicSubscription

logger = logging.getLogger(__name__)

PATIENCE = 2.0
"""Time to wait for the first state; a cloud of a release without stops has none [s]."""

PERIOD = 0.2
"""Period in which zero is delivered while the robot is stopped, as the clone does [s]."""

ZERO = msgspec.Raw(encode(Twist()))
"""The velocity of a robot that is stopped, as JSON."""


class OnboardLatch:
    """Replaces the velocities of local nodes by zero while the robot is stopped.

    The last state holds while there is no connection. On each new connection no velocity passes until the clone has
    said whether the robot is stopped now, for which it is asked again: a session that is resumed repeats nothing that
    has not changed.

    Parameters
    ----------
    client : RobotClient
        Client of the robot.
    """

    def __init__(self, client: RobotClient) -> None:
        self._client = client
        self._state: StopState | None = None
        self._heard = asyncio.Event()
        self._heard_on = self._asked_on = 0
        self._subscription: TopicSubscription[StopState] | None = None
        self._asking: asyncio.Task[None] | None = None
        self._repeating: asyncio.Task[None] | None = None

    @property
    def holds(self) -> bool:
        """Whether no velocity but zero passes now."""
        if self._state is None:
            return False
        return self._state.stopped or self._heard_on != self._client.connections

    async def open(self) -> None:
        """Begin to hear of stops; wait for the first state.

        Raises
        ------
        PPaaSError
            The client has failed.
        """
        await self._subscribe()
        try:
            async with asyncio.timeout(PATIENCE):
                await self._heard.wait()
        except TimeoutError:
            logger.warning("the cloud does not say whether the robot is stopped: stops do not hold local nodes")

    async def close(self) -> None:
        """End what goes on in the background."""
        tasks = [task for task in (self._asking, self._repeating) if task is not None]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def passed(self, topic: str, payload: msgspec.Raw) -> msgspec.Raw:
        """Return what is delivered in place of a message of a local node."""
        if topic != CMD_VEL.name or not self.holds:
            return payload
        if self._heard_on != self._client.connections != self._asked_on:
            self._asked_on = self._client.connections
            self._asking = asyncio.create_task(self._ask())
        return ZERO

    async def _subscribe(self) -> None:
        self._asked_on = self._client.connections
        before = self._subscription
        self._subscription = await self._client.subscribe(STOP_STATE.name, StopState, self._hear)
        if before is not None:
            await self._client.unsubscribe(before)

    async def _ask(self) -> None:
        """Subscribe again, by which the last state comes again."""
        try:
            await self._subscribe()
        except PPaaSError as error:
            logger.info("it is not known whether the robot is stopped: %s", error)

    def _hear(self, state: StopState) -> None:
        if self._state is None or state.stopped != self._state.stopped:
            logger.info("local nodes %s", f"stand: {state.text}" if state.stopped else "may drive")
        self._state, self._heard_on = state, self._client.connections
        self._heard.set()
        if state.stopped and (self._repeating is None or self._repeating.done()):
            self._repeating = asyncio.create_task(self._repeat())

    async def _repeat(self) -> None:
        while self._state is not None and self._state.stopped:
            self._client.deliver(CMD_VEL.name, ZERO)
            await asyncio.sleep(PERIOD)
