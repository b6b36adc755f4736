"""Client actions: actions that clients of a place advertise, and the goals that other clients sent to them."""

import itertools
import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from engine.sessions.place.asked_clients import client_asked
from engine.sessions.place.message_completion import ActionCompletion, action_completion
from ppaas.errors import MalformedMessage, NotFound, NotPermitted, PPaaSError, QuotaExceeded, Unavailable
from ppaas.listener_faults import ListenerFaults
from ppaas.messages.base.spelling import to_ros2
from ppaas.wire.actions import ABORTED, UNKNOWN

logger = logging.getLogger(__name__)

MAX_ACTIONS = 200
"""Largest number of actions that the clients of one place may advertise."""


class ActionProvider(Protocol):
    """Client that executes goals, as a place sees it. None of its methods may block."""

    def goal_requested(self, goal: int, action: str, payload: bytes) -> None:
        """Send a goal to the client, which reports feedback and the result to ``ClientActions``.

        Raises
        ------
        Unavailable
            The client is too slow to take goals.
        """
        ...

    def goal_cancelled(self, goal: int, action: str) -> None:
        """Tell the client that a goal is to be cancelled; it still reports the result.

        Raises
        ------
        Unavailable
            The client is too slow to be told.
        """
        ...


class GoalEnd(NamedTuple):
    """End of a goal: its status as in ``action_msgs/GoalStatus``, and the result as JSON, or why there is none."""

    status: int
    result: bytes | PPaaSError


@dataclass(frozen=True, slots=True)
class GoalListener:
    """Client that sent a goal.

    Parameters
    ----------
    client : int
        Number of the client.
    feedback : callable
        Called with each feedback, as JSON.
    done : callable
        Called once with the end.
    """

    client: int
    feedback: Callable[[bytes], None]
    done: Callable[[GoalEnd], None]


@dataclass(frozen=True, slots=True)
class _Offer:
    type: str
    client: int
    provider: ActionProvider
    ros2: bool
    completion: ActionCompletion


@dataclass(slots=True)
class _Goal:
    action: str
    offer: _Offer
    sent: float
    listener: GoalListener | None
    cancelled: bool = False


class ClientActions:
    """Actions that the clients of one place advertise."""

    def __init__(self) -> None:
        self._offers: dict[str, _Offer] = {}
        self._goals: dict[int, _Goal] = {}
        self._numbers = itertools.count(1)
        self._faults = ListenerFaults(logger)

    def __contains__(self, action: str) -> bool:
        """Return whether a client advertises an action."""
        return action in self._offers

    @property
    def goals(self) -> int:
        """Number of active goals."""
        return len(self._goals)

    def types(self) -> dict[str, str]:
        """Return the actions and their types, ``package/Name``."""
        return {name: offer.type for name, offer in self._offers.items()}

    def completes(self, action: str) -> bool:
        """Return whether feedback and results of an action are completed."""
        return self._offers[action].completion.result is not None

    # -- advertisements ------------------------------------------------------------------------------------------------

    def advertise(self, action: str, kind: str, client: int, provider: ActionProvider, *, ros2: bool = False) -> None:
        """Advertise an action. The newest client takes it over; goals that another has stay with that.

        ``ros2`` is whether the client spells messages as in ROS 2.

        Raises
        ------
        QuotaExceeded
            The clients of this place advertise too many actions.
        """
        if action not in self._offers and len(self._offers) >= MAX_ACTIONS:
            raise QuotaExceeded(
                f"the clients of a robot may advertise at most {MAX_ACTIONS} actions: unadvertise one first"
            )
        self._offers[action] = _Offer(kind, client, provider, ros2, action_completion(kind))

    def unadvertise(self, action: str, client: int) -> None:
        """Withdraw an action, and abort its goals.

        Raises
        ------
        NotFound
            The client does not advertise it.
        """
        offer = self._offers.get(action)
        if offer is None or offer.client != client:
            raise NotFound("offered action", action, [a for a, o in self._offers.items() if o.client == client])
        del self._offers[action]
        reason = Unavailable(f"action {action!r} was unadvertised")
        self._end_all(lambda goal: (goal.offer.client, goal.action) == (client, action), GoalEnd(ABORTED, reason))

    def leave(self, client: int) -> None:
        """Withdraw all actions of a client, end their goals, and send it nothing more about goals of its own."""
        self._offers = {name: offer for name, offer in self._offers.items() if offer.client != client}
        reason = Unavailable("the client that executed the goal has disconnected")
        self._end_all(lambda goal: goal.offer.client == client, GoalEnd(UNKNOWN, reason))
        for goal in self._goals.values():
            if goal.listener is not None and goal.listener.client == client:
                goal.listener = None

    # -- goals ---------------------------------------------------------------------------------------------------------

    def send(self, action: str, payload: bytes, now: float, listener: GoalListener) -> int:
        """Send a goal to the client that advertises an action, and return its number.

        Parameters
        ----------
        action : str
            Name of the action, without a leading slash.
        payload : bytes
            The goal as JSON.
        now : float
            Time since the epoch [s].
        listener : GoalListener
            Client that sends it.

        Raises
        ------
        MalformedMessage
            It is not a goal of the type of the action, which the cloud knows.
        Unavailable
            The client that advertises it is too slow to take goals, or fails.
        """
        offer, number = self._offers[action], next(self._numbers)
        if offer.completion.goal is not None:
            payload = offer.completion.goal(payload)
            payload = to_ros2(payload) if offer.ros2 else payload
        self._goals[number] = _Goal(action, offer, now, listener)
        try:
            with client_asked(f"action {action!r}"):
                offer.provider.goal_requested(number, action, payload)
        except PPaaSError:
            del self._goals[number]
            raise
        return number

    def cancel(self, number: int) -> None:
        """Tell the client that executes a goal to cancel it, once; nothing happens if the goal has ended.

        Raises
        ------
        Unavailable
            The client is too slow to be told.
        """
        goal = self._goals.get(number)
        if goal is not None and not goal.cancelled:
            with client_asked(f"action {goal.action!r}"):
                goal.offer.provider.goal_cancelled(number, goal.action)
            goal.cancelled = True

    def cancel_all(self, action: str, until: float) -> None:
        """Cancel the goals of an action that were sent until a time since the epoch [s]; raises as ``cancel``."""
        slow = []
        for number in [n for n, goal in self._goals.items() if goal.action == action and goal.sent <= until]:
            try:
                self.cancel(number)
            except Unavailable as error:
                slow.append(error)
        if slow:
            raise slow[0]

    def feedback(self, number: int, client: int, values: bytes) -> None:
        """Take the feedback of a goal from the client that executes it; raises as ``end``, but the goal goes on."""
        goal = self._goal_of(number, client)
        listener, complete = goal.listener, goal.offer.completion.feedback
        if complete is not None:
            values = complete(values)
        if listener is not None:
            self._faults.call(f"the sender of goal {number}", listener.feedback, values)

    def end(self, number: int, client: int, end: GoalEnd) -> None:
        """Take the result of a goal from the client that executes it.

        Raises
        ------
        NotFound
            No such goal is active.
        NotPermitted
            The goal was sent to another client.
        MalformedMessage
            The result is not of the type of the action; the goal is aborted with this error.
        """
        goal = self._goal_of(number, client)
        complete = goal.offer.completion.result
        if complete is not None and isinstance(end.result, bytes):
            try:
                end = end._replace(result=complete(end.result))
            except MalformedMessage as error:
                wrong = MalformedMessage(f"the result of action {goal.action!r}: {error}")
                self._finish(number, GoalEnd(ABORTED, wrong))
                raise wrong from error
        self._finish(number, end)

    def _goal_of(self, number: int, client: int) -> _Goal:
        goal = self._goals.get(number)
        if goal is None:
            raise NotFound("active goal", str(number))
        if goal.offer.client != client:
            raise NotPermitted(f"goal {number} was sent to another client")
        return goal

    def _end_all(self, which: Callable[[_Goal], bool], end: GoalEnd) -> None:
        for number in [number for number, goal in self._goals.items() if which(goal)]:
            self._finish(number, end)

    def _finish(self, number: int, end: GoalEnd) -> None:
        listener = self._goals.pop(number).listener
        if listener is not None:
            self._faults.call(f"the sender of goal {number}", listener.done, end)
