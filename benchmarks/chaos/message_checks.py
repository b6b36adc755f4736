"""What a robot hears, and what it should not have heard: a command twice, or two clones at a time."""

import asyncio
from collections import Counter, deque
from collections.abc import Callable

from benchmarks.chaos.silences import Silences

MOST_CYCLES = 32
"""Control cycles that a clone may have begun within a second. It begins 20, and two clones would begin 40."""


class MessageChecks:
    """Listens for one robot.

    A clone stamps what it says of each control cycle (``move_base/feedback``, which goes with each ``cmd_vel``) when it
    says it, and where the robot is (``amcl_pose``) with the stamp of the scan that told it. So a stamp that was heard
    before was said twice, an earlier one comes from another clone, and too many in a second come from two clones.

    Parameters
    ----------
    robot : str
        Its name.
    tell : callable
        Told of what should not have been heard.
    """

    def __init__(self, robot: str, tell: Callable[[str], None]) -> None:
        self._robot = robot
        self._tell = tell
        self._cycle = self._scan = 0.0
        self._cycles: deque[float] = deque()
        self.commands = 0
        self.driven = asyncio.Event()
        self.uncommanded = Silences()
        self._scans: Counter[float] = Counter()

    def commanded(self, now: float) -> None:
        """Note a ``cmd_vel``."""
        self.commands += 1
        self.driven.set()
        self.uncommanded.heard(now)

    def cycled(self, stamp: float) -> None:
        """Note the feedback of a control cycle."""
        if stamp <= self._cycle:
            self._tell(f"{self._robot} heard of a control cycle {_again(stamp, self._cycle)}")
        self._cycle = max(self._cycle, stamp)
        self._cycles.append(stamp)
        while self._cycles[0] < self._cycle - 1.0:
            self._cycles.popleft()
        if len(self._cycles) > MOST_CYCLES:
            self._tell(f"{self._robot} heard of {len(self._cycles)} control cycles within a second")
            self._cycles.clear()

    def scanned(self, stamp: float) -> None:
        """Note a scan that the robot sent; a simulated world that was held up sends several at the same moment."""
        self._scans[stamp] += 1

    def localized(self, stamp: float) -> None:
        """Note an ``amcl_pose``."""
        if stamp < self._scan or not self._scans[stamp]:
            self._tell(f"{self._robot} was told where it is by a scan {_again(stamp, self._scan)}")
        self._scan = max(self._scan, stamp)
        self._scans = Counter({sent: left for sent, left in self._scans.items() if sent >= self._scan})
        self._scans[stamp] -= 1


def _again(stamp: float, newest: float) -> str:
    if stamp > newest:
        return "that was never sent"
    return "again" if stamp == newest else f"that is {newest - stamp:.3f} s older than the last one"
