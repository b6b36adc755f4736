"""Lets go of robots that are connected and do nothing, so that their containers are there for others."""

import asyncio
from collections import Counter

from endpoints.rosbridge.session_registry import SessionRegistry
from engine.service.links.place_link import PlaceLink
from engine.service.robot_sessions import RobotSessions
from ppaas.clock import Clock, monotonic
from ppaas.errors import Idle

IDLE = 600.0
"""Seconds of silence, at a place without a goal, after which it is given up."""

LOOKS = 10
"""Looks at all places within that time."""


class IdleWatch:
    """Gives up places whose clients are connected and say nothing, and whose robot has no goal.

    Silence is counted for a place, not for a client: an operator who only looks on does not lose the robot that drives.

    Parameters
    ----------
    sessions : SessionRegistry
        Know what was said.
    robots : RobotSessions
        Let go.
    idle : float
        Seconds; 0 lets nobody go.
    clock : callable
        Monotonic seconds.
    """

    def __init__(
        self, sessions: SessionRegistry, robots: RobotSessions, idle: float = IDLE, clock: Clock = monotonic
    ) -> None:
        self._sessions = sessions
        self._robots = robots
        self._idle = idle
        self._clock = clock
        self._known: dict[PlaceLink, tuple[int, float]] = {}

    async def run(self) -> None:
        """Watch until this is cancelled."""
        while self._idle:
            await asyncio.sleep(self._idle / LOOKS)
            await self.look()

    async def look(self) -> None:
        """Let go who has been silent for too long."""
        now = self._clock()
        said: Counter[PlaceLink] = Counter()
        for attachment in self._sessions.attachments():
            said[attachment.retained.place] += 1 + attachment.retained.taken
        before, self._known = self._known, {}
        for place, count in said.items():
            counted, since = before.get(place, (-1, now))
            self._known[place] = (count, now if place.busy or count != counted else since)
        for place, (_, since) in self._known.items():
            if now - since >= self._idle:
                text = f"nothing was said for {self._idle:g} s; connect again when there is something to say"
                await self._robots.let_go(place, Idle(text))
