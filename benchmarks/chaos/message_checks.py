"""Checks of the messages to a robot: nothing may arrive twice or come from two clones at once."""

import asyncio
from collections import Counter, deque
from collections.abc import Callable

from benchmarks.chaos.silences import Silences

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
