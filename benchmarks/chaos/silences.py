"""Gaps in the messages to a robot that has a goal.

Without feedback of control cycles, no clone serves the robot: a clone sends it in every cycle, also while it replans,
recovers or waits for another robot and commands nothing. Without commands, the robot stands, for any reason.
"""

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
