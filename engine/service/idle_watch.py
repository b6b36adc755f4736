"""Idle watch: closes the places of idle robots, so that their containers are free for others."""

from engine.processes.background import repeat
from engine.service.links.place_link import PlaceLink
from engine.service.robot_sessions import RobotSessions
from ppaas.clock import Clock, monotonic
from ppaas.errors import Idle

IDLE = 600.0
"""Time without frames and without a goal after which a robot is disconnected [s]."""

CHECKS = 10
"""Number of checks of all places within that time."""


class IdleWatch:
    """Closes places whose clients are connected but send nothing, and whose robot has no goal.

    Silence is measured per place, not per client: an operator who only watches does not disconnect a driving robot.

    Parameters
    ----------
    robots : RobotSessions
        Has the places, and closes them.
    idle : float
        Time after which a place is closed [s]; 0 disables the watch.
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, robots: RobotSessions, idle: float = IDLE, clock: Clock = monotonic) -> None:
        self._robots = robots
        self._idle = idle
        self._clock = clock
        self._known: dict[PlaceLink, tuple[int, float]] = {}

    async def run(self) -> None:
        """Check all places periodically until cancelled."""
        if self._idle:
            await repeat(self.check, self._idle / CHECKS)

    async def check(self) -> None:
        """Close places that have been idle for too long."""
        now = self._clock()
        before, self._known = self._known, {}
        for place in self._robots.held():
            taken = place.beat.frames + place.beat.sockets
            counted, since = before.get(place, (-1, now))
            self._known[place] = (taken, now if place.busy or taken != counted else since)
        for place, (_, since) in self._known.items():
            if now - since >= self._idle:
                text = f"no frames for {self._idle:g} s: connect again when you have something to send"
                await self._robots.let_go(place, Idle(text))
