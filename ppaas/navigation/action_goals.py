"""How the goals of an action stand: at most one is active, and those that ended are told of for a while."""

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from ppaas.messages.actionlib_msgs import Status
from ppaas.navigation.events import CancelReceived

STATUS_LIST_TIMEOUT = 5.0
"""Seconds that a goal is told of after its end, as in actionlib."""


class ActionGoal(Protocol):
    """What is told of any goal: its id, and when it was given [s]."""

    @property
    def id(self) -> str:
        """Unique; a goal whose id is known already is the same goal, sent again."""
        ...

    @property
    def stamp(self) -> float:
        """For cancelling "all up to then"."""
        ...


G = TypeVar("G", bound=ActionGoal)


@dataclass(slots=True)
class GoalState(Generic[G]):
    """A goal and how it stands."""

    goal: G
    status: Status
    text: str
    ended: float = float("inf")


class GoalList(Generic[G]):
    """The goals that a server of an action knows of."""

    def __init__(self) -> None:
        self.active: GoalState[G] | None = None
        self._ended: list[GoalState[G]] = []

    def states(self, now: float) -> list[GoalState[G]]:
        """Return the goals to be told of, oldest first."""
        self._ended = [state for state in self._ended if now - state.ended <= STATUS_LIST_TIMEOUT]
        return [*self._ended, *([self.active] if self.active else [])]

    def knows(self, goal_id: str, now: float) -> bool:
        """Tell whether a goal of this id is active, or ended a short while ago."""
        return any(state.goal.id == goal_id for state in self.states(now))

    def accept(self, goal: G) -> None:
        """Make a goal the active one; there must be none."""
        self.active = GoalState(goal, Status.ACTIVE, "This goal has been accepted by the simple action server")

    def cancelled_by(self, event: CancelReceived) -> bool:
        """Tell whether a cancel means the active goal."""
        return self.active is not None and cancels(event, self.active.goal)

    def end(self, now: float, status: Status, text: str) -> GoalState[G]:
        """End the active goal."""
        assert self.active is not None, "no goal is active"
        ended = self.active
        ended.status, ended.text, ended.ended = status, text, now
        self._ended.append(ended)
        self.active = None
        return ended


def cancels(event: CancelReceived, goal: ActionGoal) -> bool:
    """Tell whether a cancel means a goal: by id, by stamp, or because it means all."""
    everything = not event.id and event.stamp == 0.0
    up_to = event.stamp != 0.0 and goal.stamp <= event.stamp
    return everything or up_to or event.id == goal.id
