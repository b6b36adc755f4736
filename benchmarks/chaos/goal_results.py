"""Check of goals: each goal must get one result, or its client must learn that it is lost."""

from collections import Counter
from collections.abc import Callable
from typing import Literal

from ppaas.messages.actionlib_msgs import Status

Ending = Literal["result", "status", "lost"]


class GoalResults:
    """Goals of one robot, and how they ended.

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
        self._sent: dict[str, int] = {}
        self.endings: Counter[Ending] = Counter()
        self.statuses: Counter[str] = Counter()
        self.texts: Counter[str] = Counter()

    @property
    def sent(self) -> int:
        """Number of goals sent."""
        return len(self._sent)

    def send(self, goal: str) -> None:
        """Record a goal that was sent."""
        self._sent[goal] = 0

    def result(self, goal: str) -> None:
        """Record a result; a second one for the same goal is an error."""
        if goal not in self._sent:
            self._tell(f"{self._robot} received the result of a goal that it never sent: {goal}")
            return
        self._sent[goal] += 1
        if self._sent[goal] > 1:
            self._tell(f"{self._robot} received {self._sent[goal]} results of {goal}")

    def end(self, ending: Ending, status: str, text: str = "") -> None:
        """Record the end of a goal.

        Parameters
        ----------
        ending : str
            ``result``; ``status`` if the result was lost and the list of statuses shows the end; ``lost`` if a new
            session began whose clone does not know the goal, or if the client gave up.
        status : str
            Final status of the goal.
        text : str
            Reason of a goal that the robot has not reached.
        """
        self.endings[ending] += 1
        self.statuses[status] += 1
        if status != Status.SUCCEEDED.name:
            self.texts[f"{self._robot}: {status}, {text}"] += 1

    def forgotten(self, goal: str) -> None:
        """Record that a clone does not know a goal although no new session began."""
        self._tell(f"{self._robot}: the clone lost {goal} without a new session")

    def missing(self, goal: str, seconds: float, trace: str) -> None:
        """Report a goal that has neither ended nor been lost within a time limit [s], with its trace."""
        self._tell(f"{self._robot}: {goal} did not end within {seconds:.0f} s: {trace}")
