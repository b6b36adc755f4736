"""Goals of an action server: the active goal, and those that ended recently."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from ppaas.messages.actionlib_msgs import Status
from ppaas.navigation.events import CancelReceived

STATUS_LIST_TIMEOUT = 5.0
"""Time for which a goal stays in the status list after its end, as in actionlib [s]."""


class ActionGoal(Protocol):
    """Goal of any action."""

    @property
    def id(self) -> str:
        """Unique id; a goal with a known id is the same goal, sent again."""
        ...

    @property
    def stamp(self) -> float:
        """Time of the request, for cancels of all goals up to a time [s]."""
        ...


G = TypeVar("G", bound=ActionGoal)


@dataclass(slots=True)
class GoalState(Generic[G]):
    """Goal, its status and the text of its status; ``ended`` is the time of its end [s]."""

    goal: G
    status: Status
    text: str
    ended: float = float("inf")


class GoalStates(Protocol):
    """Goals that an action server knows."""

    def states(self, now: float) -> Sequence[GoalState[Any]]:
        """Return the goals of the status list."""
        ...


class GoalList(Generic[G]):
    """Goals that an action server knows: at most one active goal, and those that ended recently."""

    def __init__(self) -> None:
        self.active: GoalState[G] | None = None
        self._ended: list[GoalState[G]] = []

    def states(self, now: float) -> list[GoalState[G]]:
        """Return the goals of the status list, oldest first."""
        self._ended = [state for state in self._ended if now - state.ended <= STATUS_LIST_TIMEOUT]
        return [*self._ended, *([self.active] if self.active else [])]

    def knows(self, goal_id: str, now: float) -> bool:
        """Return whether a goal with this id is active or ended recently."""
        return any(state.goal.id == goal_id for state in self.states(now))

    def accept(self, goal: G) -> None:
        """Make a goal the active one; no other may be active."""
        self.active = GoalState(goal, Status.ACTIVE, "This goal has been accepted by the simple action server")

    def cancelled_by(self, event: CancelReceived) -> bool:
        """Return whether a cancel applies to the active goal."""
        return self.active is not None and cancels(event, self.active.goal)

    def end(self, now: float, status: Status, text: str) -> GoalState[G]:
        """End the active goal."""
        assert self.active is not None, "no goal is active"
        ended = self.active
        ended.status, ended.text, ended.ended = status, text, now
        self._ended.append(ended)
        self.active = None
        return ended

    def refuse(self, goal: G, now: float, text: str) -> None:
        """Add a goal that was aborted before it became active."""
        self._ended.append(GoalState(goal, Status.ABORTED, text, now))


class ConcurrentGoals(Generic[G]):
    """Goals of an action server that works on several at once, and those that ended recently."""

    def __init__(self) -> None:
        self._active: dict[str, GoalState[G]] = {}
        self._ended: list[GoalState[G]] = []

    def states(self, now: float) -> list[GoalState[G]]:
        """Return the goals of the status list: those that ended, then the active ones."""
        self._ended = [state for state in self._ended if now - state.ended <= STATUS_LIST_TIMEOUT]
        return [*self._ended, *self._active.values()]

    def knows(self, goal_id: str, now: float) -> bool:
        """Return whether a goal with this id is active or ended recently."""
        return any(state.goal.id == goal_id for state in self.states(now))

    @property
    def active(self) -> list[G]:
        """The active goals, oldest first."""
        return [state.goal for state in self._active.values()]

    def accept(self, goal: G, text: str) -> None:
        """Add an active goal."""
        self._active[goal.id] = GoalState(goal, Status.ACTIVE, text)

    def end(self, goal: G, now: float, status: Status, text: str) -> None:
        """End an active goal."""
        ended = self._active.pop(goal.id)
        ended.status, ended.text, ended.ended = status, text, now
        self._ended.append(ended)


def cancels(event: CancelReceived, goal: ActionGoal) -> bool:
    """Return whether a cancel applies to a goal: by id, by stamp, or because it cancels all goals."""
    everything = not event.id and event.stamp == 0.0
    up_to = event.stamp != 0.0 and goal.stamp <= event.stamp
    return everything or up_to or event.id == goal.id
