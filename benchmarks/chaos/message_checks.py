"""Checks of the messages to a robot: none twice or from two clones at once, gaps in them, and where it strayed.

Without feedback of control cycles, no clone serves the robot: a clone sends it in every cycle, also while it replans,
recovers or waits for another robot and commands nothing. Without commands, the robot stands, for any reason.
"""

import asyncio
from collections import Counter, deque
from collections.abc import Callable
from typing import NamedTuple

NOTEWORTHY = 0.5
"""Shortest silence that is a gap [s]: the time for which a base continues with its last command."""


class Gap(NamedTuple):
    """Time without a message while the robot had a goal [monotonic s]."""

    begin: float
    end: float

    @property
    def seconds(self) -> float:
        """Duration [s]."""
        return self.end - self.begin


class Silences:
    """Gaps in one kind of messages to a robot."""

    def __init__(self) -> None:
        self._since: float | None = None
        self.gaps: list[Gap] = []

    def goal_sent(self, now: float) -> None:
        """Expect messages from now on [monotonic s]."""
        self._since = now

    def heard(self, now: float) -> None:
        """Record a message."""
        if self._since is not None:
            self._note(self._since, now)
            self._since = now

    def goal_ended(self, now: float) -> None:
        """Expect no more messages."""
        self.heard(now)
        self._since = None

    def _note(self, since: float, now: float) -> None:
        if now - since >= NOTEWORTHY:
            self.gaps.append(Gap(since, now))


MOST_CYCLES = 32
"""Largest number of control cycles of one clone within a second: one clone runs 20, two would run 40."""


class MessageChecks:
    """Checks the messages to one robot.

    A clone stamps the feedback of each control cycle (``move_base/feedback``, sent with each ``cmd_vel``) with the
    current time, and ``amcl_pose`` with the stamp of the scan that it used. So a repeated stamp is a message sent
    twice, an earlier stamp comes from another clone, and too many stamps within a second come from two clones.

    Parameters
    ----------
    robot : str
        Name of the robot.
    tell : callable
        Called with a description of each error.
    """

    def __init__(self, robot: str, tell: Callable[[str], None]) -> None:
        self._robot = robot
        self._tell = tell
        self._cycle = self._scan = 0.0
        self._cycles: deque[float] = deque()
        self.commands = self.cycles = 0
        self.driven = asyncio.Event()
        self.uncommanded = Silences()
        self._scans: Counter[float] = Counter()

    def commanded(self, now: float) -> None:
        """Record a ``cmd_vel`` at a monotonic time [s]."""
        self.commands += 1
        self.driven.set()
        self.uncommanded.heard(now)

    def cycled(self, stamp: float) -> None:
        """Check the stamp of the feedback of a control cycle [s]."""
        if stamp <= self._cycle:
            self._tell(f"{self._robot} received the feedback of a control cycle {_again(stamp, self._cycle)}")
        self._cycle = max(self._cycle, stamp)
        self.cycles += 1
        self._cycles.append(stamp)
        while self._cycles[0] < self._cycle - 1.0:
            self._cycles.popleft()
        if len(self._cycles) > MOST_CYCLES:
            self._tell(f"{self._robot} received the feedback of {len(self._cycles)} control cycles within a second")
            self._cycles.clear()

    def scanned(self, stamp: float) -> None:
        """Record the stamp of a scan that the robot sent; a delayed simulation sends several with the same stamp."""
        self._scans[stamp] += 1

    def localized(self, stamp: float) -> None:
        """Check the stamp of an ``amcl_pose`` [s]."""
        if stamp < self._scan or not self._scans[stamp]:
            self._tell(f"{self._robot} received the pose of a scan {_again(stamp, self._scan)}")
        self._scan = max(self._scan, stamp)
        self._scans = Counter({sent: left for sent, left in self._scans.items() if sent >= self._scan})
        self._scans[stamp] -= 1


def _again(stamp: float, newest: float) -> str:
    if stamp > newest:
        return "that was never sent"
    return "again" if stamp == newest else f"that is {newest - stamp:.3f} s older than the last one"


FAR = 1.0
"""Distance between a robot and the pose that its clone publishes from which the robot counts as astray [m]."""


class Strays:
    """Times in which one robot was astray."""

    def __init__(self) -> None:
        self._since: float | None = None
        self.gaps: list[Gap] = []

    def look(self, metres: float, now: float) -> None:
        """Record the distance between the robot and its believed pose [m] at a time [monotonic s]."""
        if metres < FAR:
            self.end(now)
        elif self._since is None:
            self._since = now

    def end(self, now: float) -> None:
        """Record that the robot has left, or was found again."""
        if self._since is not None:
            self.gaps.append(Gap(self._since, now))
        self._since = None
