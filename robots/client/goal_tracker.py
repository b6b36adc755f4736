"""Tracking of one goal by its result and by the periodic status lists.

A result message is lost if the cloud was killed, or if the robot's session ended before the result was delivered. Move
Base publishes the status list periodically, so the tracker can still learn how the goal ended, or that Move Base does
not know it any more.
"""

import asyncio

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.move_base_msgs import MoveBaseActionResult

SETTLED = 5.0
"""Time for which the status lists must agree before they replace a missing result [s]."""

MIN_LISTS = 4
"""Number of consecutive status lists without the goal before it counts as unknown."""


class TrackedGoal:
    """State of one goal.

    Parameters
    ----------
    goal : str
        Id of the goal.

    Attributes
    ----------
    result : Future
        Final status; set when the goal has ended.
    status : GoalStatus
        Status in the last list that contained the goal.
    """

    def __init__(self, goal: str) -> None:
        self.goal = goal
        self.result: asyncio.Future[GoalStatus] = asyncio.get_running_loop().create_future()
        self.status = GoalStatus(GoalID(id=goal), Status.PENDING)
        self._over_since: float | None = None
        self._unknown_since: float | None = None
        self._lists = 0

    def on_result(self, message: MoveBaseActionResult) -> None:
        """Process a result; results of other goals are ignored."""
        if message.status.goal_id.id == self.goal and not self.result.done():
            self.result.set_result(message.status)

    def on_status(self, message: GoalStatusArray, now: float) -> None:
        """Process a status list received at the time ``now`` [s]."""
        own = [one for one in message.status_list if one.goal_id.id == self.goal]
        if not own:
            self._lists += 1
            self._unknown_since = now if self._unknown_since is None else self._unknown_since
            return
        self.status, self._unknown_since, self._lists = own[-1], None, 0
        if not Status(self.status.status).terminal:
            self._over_since = None
        elif self._over_since is None:
            self._over_since = now

    def is_over(self, now: float) -> bool:
        """Return whether the status lists show a final status, and the result is overdue."""
        return self._over_since is not None and now - self._over_since > SETTLED

    def is_unknown(self, now: float) -> bool:
        """Return whether the last status lists did not contain the goal."""
        return self._unknown_since is not None and self._lists >= MIN_LISTS and now - self._unknown_since > SETTLED
