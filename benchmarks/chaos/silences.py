"""When a robot that had a goal heard nothing of some kind.

Of control cycles: then nobody served it. One that is served hears of each, also while it is commanded nothing: its
clone plans anew, recovers, or waits for another robot to make way. Of commands: then it stood, for whatever reason.
"""

from typing import NamedTuple

NOTEWORTHY = 0.5
"""Seconds of silence that are a gap: as long as a base drives on by its last command."""


class Gap(NamedTuple):
    """Time in which nothing was heard while there was a goal, from and to [monotonic s]."""

    begin: float
    end: float

    @property
    def seconds(self) -> float:
        """How long it was."""
        return self.end - self.begin


class Silences:
    """Gaps in what a robot hears of one kind."""

    def __init__(self) -> None:
        self._since: float | None = None
        self.gaps: list[Gap] = []

    def goal_sent(self, now: float) -> None:
        """Expect to hear something from now on [monotonic s]."""
        self._since = now

    def heard(self, now: float) -> None:
        """Note that something was heard."""
        if self._since is not None:
            self._note(self._since, now)
            self._since = now

    def goal_ended(self, now: float) -> None:
        """Expect no more."""
        self.heard(now)
        self._since = None

    def _note(self, since: float, now: float) -> None:
        if now - since >= NOTEWORTHY:
            self.gaps.append(Gap(since, now))
