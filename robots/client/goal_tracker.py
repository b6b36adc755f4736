"""One goal, from the moment that it was sent, by what is told of it.

A result may be lost: where the cloud was killed, or the robot's session had ended before it came. How goals stand is
told again and again, so the lists of statuses tell how such a goal ended, or that nobody knows it any more.
"""

import asyncio

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.move_base_msgs import MoveBaseActionResult

SETTLED = 5.0
"""Seconds for which the lists of statuses must agree before they are believed where no result came."""

LISTS = 4
"""How many of them must, at least."""


class Following:
    """Follows one goal.

    Parameters
    ----------
    goal : str
        Its id.

    Attributes
    ----------
    result : Future
        How it ended, once its result is there.
    status : GoalStatus
        How it stands, as it was told last.
    """

    def __init__(self, goal: str) -> None:
        self.goal = goal
        self.result: asyncio.Future[GoalStatus] = asyncio.get_running_loop().create_future()
        self.status = GoalStatus(GoalID(id=goal), Status.PENDING)
        self._over_since: float | None = None
        self._unknown_since: float | None = None
        self._lists = 0

    def ended(self, message: MoveBaseActionResult) -> None:
        """Take a result, perhaps of another goal."""
        if message.status.goal_id.id == self.goal and not self.result.done():
            self.result.set_result(message.status)

    def listed(self, message: GoalStatusArray, now: float) -> None:
        """Take a list of statuses."""
        mine = [one for one in message.status_list if one.goal_id.id == self.goal]
        if not mine:
            self._lists += 1
            self._unknown_since = now if self._unknown_since is None else self._unknown_since
            return
        self.status, self._unknown_since, self._lists = mine[-1], None, 0
        if not Status(self.status.status).terminal:
            self._over_since = None
        elif self._over_since is None:
            self._over_since = now

    def is_over(self, now: float) -> bool:
        """Tell whether the lists say that it has ended, and its result does not come."""
        return self._over_since is not None and now - self._over_since > SETTLED

    def is_unknown(self, now: float) -> bool:
        """Tell whether the lists do not have it, one after the other."""
        return self._unknown_since is not None and self._lists >= LISTS and now - self._unknown_since > SETTLED
