"""Publisher of an action's status, feedback and results."""

from collections.abc import Callable
from typing import Generic, cast

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.navigation.action_goals import ActionGoal, G, GoalStates
from ppaas.nodes.base import Context
from ppaas.nodes.nav2_actions import Nav2ActionTopics


class ActionPublisher(Generic[G]):
    """Publishes what an action server says about its goals.

    Parameters
    ----------
    context : Context
        Context of the node that serves the action.
    topics : Nav2ActionTopics
    """

    def __init__(self, context: Context, topics: Nav2ActionTopics) -> None:
        self._context = context
        self._topics = topics

    def status(self, goals: GoalStates) -> None:
        """Publish the status of all goals."""
        self._context.publish(self._topics.status.name, status_array(goals, self._context))

    def feedback(self, goal: G, feedback: Message, text: str = "") -> None:
        """Publish feedback of an active goal."""
        make = cast(Callable[..., Message], self._topics.feedback.type)
        status = status_of(goal, Status.ACTIVE, text)
        self._context.publish(self._topics.feedback.name, make(header=self._header(), status=status, feedback=feedback))

    def result(self, goal: G, status: Status, text: str, result: Message) -> None:
        """Publish the result of a goal that has ended."""
        make = cast(Callable[..., Message], self._topics.result.type)
        ended = status_of(goal, status, text)
        self._context.publish(self._topics.result.name, make(header=self._header(), status=ended, result=result))

    def _header(self) -> Header:
        return Header(stamp=Time.of(self._context.now()))


def status_of(goal: ActionGoal, status: Status, text: str) -> GoalStatus:
    """Return the status of a goal of any action as a message."""
    return GoalStatus(GoalID(Time.of(goal.stamp), goal.id), int(status), text)


def status_array(goals: GoalStates, context: Context) -> GoalStatusArray:
    """Return the status of all goals of an action as a message, stamped with the current time."""
    listed = [status_of(state.goal, state.status, state.text) for state in goals.states(context.elapsed())]
    return GoalStatusArray(Header(stamp=Time.of(context.now())), listed)
