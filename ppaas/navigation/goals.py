"""How goals stand: at most one is active, and those that ended are told of for a while."""

from dataclasses import dataclass

from ppaas.messages.actionlib_msgs import Status
from ppaas.navigation.events import CancelReceived, Goal

STATUS_LIST_TIMEOUT = 5.0
"""Seconds that a goal is told of after its end, as in actionlib."""


@dataclass(slots=True)
class GoalState:
    """A goal and how it stands."""

    goal: Goal
    status: Status
    text: str
    ended: float = float("inf")


class GoalList:
    """The goals that Move Base knows of."""

    def __init__(self) -> None:
        self.active: GoalState | None = None
        self._ended: list[GoalState] = []

    def states(self, now: float) -> list[GoalState]:
        """Return the goals to be told of, oldest first."""
        self._ended = [state for state in self._ended if now - state.ended <= STATUS_LIST_TIMEOUT]
        return [*self._ended, *([self.active] if self.active else [])]

    def knows(self, goal_id: str, now: float) -> bool:
        """Tell whether a goal of this id is active, or ended a short while ago."""
        return any(state.goal.id == goal_id for state in self.states(now))

    def accept(self, goal: Goal) -> None:
        """Make a goal the active one; there must be none."""
        self.active = GoalState(goal, Status.ACTIVE, "This goal has been accepted by the simple action server")

    def cancelled_by(self, event: CancelReceived) -> bool:
        """Tell whether a cancel means the active goal: by id, by stamp, or because it means all."""
        if self.active is None:
            return False
        goal = self.active.goal
        everything = not event.id and event.stamp == 0.0
        up_to = event.stamp != 0.0 and goal.stamp <= event.stamp
        return everything or up_to or event.id == goal.id

    def end(self, now: float, status: Status, text: str) -> GoalState:
        """End the active goal."""
        assert self.active is not None, "no goal is active"
        ended = self.active
        ended.status, ended.text, ended.ended = status, text, now
        self._ended.append(ended)
        self.active = None
        return ended
