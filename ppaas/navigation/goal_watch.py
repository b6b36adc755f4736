"""Goal watch: what the status lists of an action say of a goal whose result may be lost.

The result of a goal is one message. It is lost with the container that sends it, or while its reader is away. The lists
of statuses are repeated, so they still show how the goal ended, or that its action does not know it any more.

One rule ends a goal without its result: ``MIN_LISTS`` lists in a row, of which the last came ``SETTLED`` after the
first, do not show it as active. It has then ended with the last final status that a list had of it, or is lost. So a
goal that lists keep naming is never lost, nor one whose lists stop coming, and a clone that starts has time to receive
it again.
"""

from collections.abc import Iterable

from ppaas.errors import MalformedMessage
from ppaas.messages.actionlib_msgs import GoalStatus, Status

SETTLED = 5.0
"""Time for which lists do not show a goal as active until it ends without its result [s]."""

MIN_LISTS = 4
"""Number of lists in a row that do not show a goal as active until it ends without its result."""

LOST_TEXT = "its clone does not know this goal any more: send it again"
"""Text of a goal that is lost."""


class GoalWatch:
    """Watch of one goal by the status lists of its action.

    Parameters
    ----------
    goal_id : str
        Id of the goal.

    Attributes
    ----------
    status : Status
        Its status in the last list that had it; ``PENDING`` before.
    text : str
        Text of that.
    """

    def __init__(self, goal_id: str) -> None:
        self._id = goal_id
        self.status, self.text = Status.PENDING, ""
        self._since = 0.0
        self._lists = 0

    @property
    def has_ended(self) -> bool:
        """Whether the last list that had the goal shows its end: for those who need nothing else of its result."""
        return self.status.terminal

    def see(self, listed: Iterable[GoalStatus], now: float) -> Status | None:
        """Take a list of statuses; return how the goal ended, by the rule, or None.

        Parameters
        ----------
        listed : iterable of GoalStatus
            All statuses of the list.
        now : float
            Monotonic time at which it came [s].

        Raises
        ------
        MalformedMessage
            The status of the goal has a number that ``actionlib_msgs/GoalStatus`` does not have; nothing is changed.
        """
        own = [one for one in listed if one.goal_id.id == self._id]
        if own:
            self.status, self.text = status_of(own[-1]), own[-1].text
            if not self.status.terminal:
                self._lists = 0
                return None
        if not self._lists:
            self._since = now
        self._lists += 1
        if self._lists < MIN_LISTS or now - self._since < SETTLED:
            return None
        if not self.status.terminal:
            self.text = LOST_TEXT
            return Status.LOST
        return self.status


def status_of(status: GoalStatus) -> Status:
    """Return the status of a goal; ``MalformedMessage`` if its number is unknown."""
    try:
        return Status(status.status)
    except ValueError as error:
        raise MalformedMessage(f"{status.status} is not a goal status of actionlib_msgs/GoalStatus") from error
