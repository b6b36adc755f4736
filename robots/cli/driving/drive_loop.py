"""Loop of a driver by hand: sends what a source wants, 20 times a second, until the source ends."""

import asyncio
import contextlib
from collections.abc import Callable
from typing import Protocol

from ppaas.clock import monotonic
from ppaas.errors import Conflict
from ppaas.messages.operators.teleoperation import DriverRequest, TeleopState
from robots.client.teleop import Hand

PERIOD = 0.05
"""Time between two commands [s]."""


class MotionSource(Protocol):
    """Where the wanted motion comes from.

    Attributes
    ----------
    changed : Event
        Set when another motion is wanted.
    """

    changed: asyncio.Event

    def end(self, now: float) -> DriverRequest:
        """Return ``LEAVE`` or ``GIVE_BACK`` if driving ends, else ``NOTHING``."""
        ...

    def velocity(self, state: TeleopState, now: float) -> tuple[float, float] | None:
        """Return the wanted velocity [m/s, rad/s]; None while the control is let go."""
        ...


async def drive_by(hand: Hand, source: MotionSource, show: Callable[[Hand], None]) -> None:
    """Drive until the source ends; ``show`` is called after each command.

    Raises
    ------
    Conflict
        Another has taken over, or the turn has lapsed.
    """
    while not (end := source.end(monotonic())):
        state = hand.state
        if not hand.drives or state is None:
            raise Conflict(_why_lost(state))
        velocity = source.velocity(state, monotonic())
        await (hand.let_go() if velocity is None else hand.drive(*velocity))
        show(hand)
        await _wait(source.changed)
    await hand.leave(give_back=end is DriverRequest.GIVE_BACK)


def _why_lost(state: TeleopState | None) -> str:
    if state is not None and state.id:
        return f"{state.driver or 'somebody else'} has taken over"
    return "no command came to the robot for too long, so that the turn has ended: begin again"


async def _wait(changed: asyncio.Event) -> None:
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(PERIOD):
            await changed.wait()
    changed.clear()
