"""What became of goals: each that was sent gets one result, or who sent it learns that it is lost."""

from collections import Counter
from collections.abc import Callable
from typing import Literal

Ending = Literal["result", "status", "lost"]


class GoalResults:
    """Keeps the books of one robot.

    Parameters
    ----------
    robot : str
        Its name.
    tell : callable
        Told of what should not have been.
    """

    def __init__(self, robot: str, tell: Callable[[str], None]) -> None:
        self._robot = robot
        self._tell = tell
        self._sent: dict[str, int] = {}
        self.endings: Counter[Ending] = Counter()
        self.statuses: Counter[str] = Counter()

    @property
    def sent(self) -> int:
        """How many there were."""
        return len(self._sent)

    def send(self, goal: str) -> None:
        """Note a goal that was sent."""
        self._sent[goal] = 0

    def result(self, goal: str) -> None:
        """Note a result."""
        if goal not in self._sent:
            self._tell(f"{self._robot} heard of a goal that it never had: {goal}")
            return
        self._sent[goal] += 1
        if self._sent[goal] > 1:
            self._tell(f"{self._robot} heard of the end of {goal} {self._sent[goal]} times")

    def end(self, ending: Ending, status: str) -> None:
        """Note what became of a goal.

        Parameters
        ----------
        ending : str
            ``result``; ``status``, where the result was lost and the list of statuses tells of it; ``lost``, where a
            session began anew in which the clone does not know the goal, or the client gave up: both are told of it.
        status : str
            How it ended.
        """
        self.endings[ending] += 1
        self.statuses[status] += 1

    def forgotten(self, goal: str) -> None:
        """Note that a clone does not know a goal, and nobody was told that it is lost."""
        self._tell(f"{self._robot}: {goal} was forgotten, and nobody was told")

    def missing(self, goal: str, seconds: float) -> None:
        """Note that nobody told of the end of a goal."""
        self._tell(f"{self._robot}: nothing was heard of the end of {goal} in {seconds:.0f} s")
