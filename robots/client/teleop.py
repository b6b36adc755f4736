"""Driving by hand from a program: the driver's side of ``teleop_cmd`` and ``teleop_state``.

::

    async with RobotClient(url, robot="tb1", token=token, role="operator") as client, driving_by_hand(client) as hand:
        for _ in range(20):
            await hand.drive(0.2)
            await asyncio.sleep(0.05)
"""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from uuid import uuid4

from ppaas.bounded import BoundedDict
from ppaas.clock import monotonic
from ppaas.errors import Conflict, Unavailable
from ppaas.messages.operators.teleoperation import DriverRequest, TeleopCommand, TeleopMode, TeleopState
from ppaas.nodes.topics import TELEOP_CMD, TELEOP_STATE
from robots.client.robot_client import RobotClient

PERIOD = 0.05
"""Time between two requests [s]."""

KEPT = 64
"""Number of commands whose times are known."""

PATIENCE = 5.0
"""Time limit for the answer to a request [s]."""


class Hand:
    """A program that drives a robot by hand; `driving_by_hand` makes it the driver.

    Parameters
    ----------
    client : RobotClient
        An operator of the robot.

    Attributes
    ----------
    id : str
        Id as the driver.
    state : TeleopState or None
        Last state of the robot.
    round_trip : float or None
        Time from a command to the state that answers it, of the last one that was answered [s]; None before the first.
    """

    def __init__(self, client: RobotClient) -> None:
        self.id = uuid4().hex
        self.state: TeleopState | None = None
        self.round_trip: float | None = None
        self._sent: BoundedDict[int, float] = BoundedDict(KEPT)
        self._client = client
        self._heard_at = monotonic()
        self._number = 0

    @property
    def drives(self) -> bool:
        """Whether it is the driver."""
        return self.state is not None and self.state.id == self.id

    def hear(self, state: TeleopState) -> None:
        """Take a state of the robot."""
        self.state, self._heard_at = state, monotonic()
        if self.drives and (sent := self._sent.pop(state.command, None)) is not None:
            self.round_trip = self._heard_at - sent

    async def begin(self, *, take_over: bool = False) -> None:
        """Become the driver.

        Raises
        ------
        Conflict
            Another drives; with ``take_over``, this one replaces it instead.
        Unavailable
            The robot is not driven by hand, or does not answer.
        """
        request = DriverRequest.TAKE_OVER if take_over else DriverRequest.DRIVE
        until = monotonic() + PATIENCE
        while not self.drives:
            if self.state is not None and self.state.mode == TeleopMode.REFUSED:
                raise Unavailable(f"the robot cannot be driven by hand: {self.state.text}")
            if self.state is not None and self.state.id and not take_over:
                raise Conflict(f"{self.state.driver} drives the robot: take over, or wait")
            if monotonic() > until:
                raise Unavailable("the robot does not answer: it has no container that can be driven by hand")
            await self._send(request=request)
            await asyncio.sleep(PERIOD)

    async def drive(self, linear: float = 0.0, angular: float = 0.0) -> None:
        """Send one command [m/s, rad/s]; without the next one within 0.3 s the robot stops.

        Raises
        ------
        Conflict
            Another has taken over, or the turn has lapsed.
        """
        if not self.drives:
            raise Conflict("this program drives the robot no longer: begin again")
        await self._send(linear, angular, enable=True)

    async def let_go(self) -> None:
        """Stop the robot; after a fault, it drives again after this."""
        await self._send()

    async def leave(self, *, give_back: bool = False) -> None:
        """Drive no longer; with ``give_back``, the robot goes on to the goal that it had, at once."""
        await self._send(request=DriverRequest.GIVE_BACK if give_back else DriverRequest.LEAVE)

    async def _send(
        self, linear: float = 0.0, angular: float = 0.0, *, enable: bool = False, request: str = ""
    ) -> None:
        self._number += 1
        self._sent[self._number] = monotonic()
        seen = 0 if self.state is None else self.state.number
        command = TeleopCommand(
            self.id, self._number, linear, angular, enable, echo=seen, held=monotonic() - self._heard_at, view=seen,
            request=request,
        )  # fmt: skip
        await self._client.publish(TELEOP_CMD.name, command)


@asynccontextmanager
async def driving_by_hand(client: RobotClient, *, take_over: bool = False) -> AsyncIterator[Hand]:
    """Drive a robot by hand until the end of the block.

    Raises
    ------
    Conflict, Unavailable
        As `Hand.begin`.
    """
    hand = Hand(client)
    subscription = await client.subscribe(TELEOP_STATE.name, TeleopState, hand.hear)
    try:
        await hand.begin(take_over=take_over)
        yield hand
    finally:
        await hand.leave()
        await client.unsubscribe(subscription)
