"""Tracking of one goal by its result and by the periodic status lists.

A result message is lost if the cloud was killed, or if the robot's session ended before the result was delivered. Move
Base publishes the status list periodically, so the tracker can still learn how the goal ended, or that Move Base does
not know it any more (see `ppaas.navigation.goal_watch`).
"""

import asyncio

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.navigation.goal_watch import GoalWatch


class TrackedGoal:
    """State of one goal.

    Parameters
    ----------
    goal : str
        Id of the goal.

    Attributes
    ----------
    result : Future
        Final status; set when the goal has ended, by its result or by the lists. `Status.LOST` if it is not known any
        more.
    has_result : bool
        Whether it ended by its result.
    """

    def __init__(self, goal: str) -> None:
        self.goal = goal
        self.result: asyncio.Future[GoalStatus] = asyncio.get_running_loop().create_future()
        self.has_result = False
        self._watch = GoalWatch(goal)

    @property
    def status(self) -> GoalStatus:
        """Status in the last list that contained the goal."""
        return GoalStatus(GoalID(id=self.goal), self._watch.status, self._watch.text)

    def on_result(self, message: MoveBaseActionResult) -> None:
        """Process a result; results of other goals are ignored."""
        if message.status.goal_id.id == self.goal and not self.result.done():
            self.has_result = True
            self.result.set_result(message.status)

    def on_status(self, message: GoalStatusArray, now: float) -> None:
        """Process a status list received at the monotonic time ``now`` [s]."""
        end = self._watch.see(message.status_list, now)
        if end is not None and not self.result.done():
            self.result.set_result(GoalStatus(GoalID(id=self.goal), end, self._watch.text))
