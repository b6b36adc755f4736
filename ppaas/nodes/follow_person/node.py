"""Node ``follow_person``: follows the person of its robot's order, with goals of Move Base that move."""

from typing import ClassVar

import msgspec

from ppaas.costmap.map_layers import MapLayers
from ppaas.decoding import from_json
from ppaas.errors import TransformError
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.people_coordination import (
    IDLE,
    PAUSED,
    WAITING,
    FollowOrder,
    FollowStatus,
    PeopleReport,
    PeopleState,
    SensorView,
)
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Demands, Node, Payload, Topic
from ppaas.nodes.follow_person.move_base_link import MoveBaseLink, MoveOutcome
from ppaas.nodes.frames import MAP, FrameListener, FrameNames
from ppaas.people.following.following import Following, FollowStep
from ppaas.people.following.parameters import FollowParameters
from ppaas.people.following.places import Places
from ppaas.people.state_checks import check_state

PERIOD, STATUS_PERIOD = 0.2, 1.0
"""Periods of decisions, and of the status [s]."""

SILENCE = 3.0
"""Time without a message of the coordinator after which the robot stands [s]."""


class FollowPersonState(msgspec.Struct):
    """Checkpoint: number of goals sent, the order with the reason for giving up, and the rest of a pause [s]."""

    counter: int
    order: tuple[int, float] = (0, 0.0)
    gave_up: str = ""
    not_found: bool = False
    pause: float = 0.0


class FollowPersonNode(Node):
    """Follows a person by order of the coordinator.

    Goals of clients take precedence: while Move Base, the waypoint follower or a behaviour has one, following pauses.
    A client that cancels the node's goal, or all goals, pauses it for ``cancel_pause``.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : FollowParameters
    robot : str
        Robot ID.
    layers : MapLayers
        The map, inflated for the robot.
    names : FrameNames, optional
        Names of the robot's frames.
    """

    name: ClassVar[str] = "follow_person"
    demands: ClassVar[Demands] = Demands(0.05)
    subscribes: ClassVar[tuple[Topic, ...]] = (
        topics.PEOPLE_STATE, topics.PEOPLE_REPORT, topics.TF, topics.TF_STATIC, *MoveBaseLink.subscribes,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (topics.FOLLOW_STATUS, *MoveBaseLink.publishes)

    def __init__(
        self, context: Context, parameters: FollowParameters, robot: str, layers: MapLayers,
        names: FrameNames | None = None,
    ) -> None:  # fmt: skip
        super().__init__(context)
        self._parameters, self._robot, self._places = parameters, robot, Places(layers)
        self._frames = FrameListener(names)
        # A timer may be a little early: the goal moves at the rate of the parameter all the same.
        self._link = MoveBaseLink(context, 0.9 / parameters.frequency)
        self._views: list[SensorView] = [
            SensorView(0.0, 0.0, 0.0, parameters.field_of_view, 0.0, parameters.view_range)
        ]
        self._state: PeopleState | None = None
        self._state_at = float("-inf")
        self._order: FollowOrder | None = None
        self._following: Following | None = None
        self._restored = FollowPersonState(0)
        self._paused_until = float("-inf")
        self._status: FollowStatus | None = None

    @property
    def busy(self) -> bool:
        """Whether the robot has an order."""
        return self._order is not None

    def start(self) -> None:
        """Start to follow, and to publish the status."""
        self.context.every(PERIOD, self._step)
        self.context.every(STATUS_PERIOD, self._publish_status)

    def use_layers(self, layers: MapLayers) -> None:
        """Replace the map."""
        self._places = Places(layers)
        if self._following is not None:
            self._following.use_places(self._places)

    # -- messages ------------------------------------------------------------------------------------------------------

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message.

        Raises
        ------
        InvalidInput
            A number is not finite.
        TransformError
            A transform is not valid.
        """
        match message:
            case TFMessage():
                self._frames.hear(topic, message, self.context.elapsed(), self.context.now())
            case PeopleState():
                self._on_state(message)
            case PeopleReport():
                if message.views:
                    self._views = message.views
            case _:
                self._on_outcome(self._link.take(topic, message))

    def _on_state(self, state: PeopleState) -> None:
        check_state(state)
        now = self.context.elapsed()
        self._state, self._state_at = state, now
        order = next((order for order in state.orders if order.robot == self._robot), None)
        if _key(order) != _key(self._order):
            self._take_order(order)
        if self._following is not None:
            self._following.hear(state, now)

    def _take_order(self, order: FollowOrder | None) -> None:
        """Begin to follow the person of an order; one who is followed already is followed on, unless given up."""
        before, self._order = self._order, order
        following = self._following
        if order is None:
            self._following = None
            self._link.stop()
            return
        if following is None or before is None or before.person != order.person or following.gave_up:
            now = self.context.elapsed()
            self._following = Following(order.person, self._robot, self._parameters, self._places, now)
            if self._restored.order == _key(order):
                self._following.give_up(self._restored.gave_up, not_found=self._restored.not_found)
            if before is None and self._state is not None:
                self._following.hear(self._state, now)
                self._step()

    def _on_outcome(self, outcome: MoveOutcome | None) -> None:
        if outcome is MoveOutcome.CANCELLED and self._order is not None and not self._link.has_client:
            self._link.stop()
            self._paused_until = self.context.elapsed() + self._parameters.cancel_pause
            self._step()
        elif outcome is MoveOutcome.PREEMPTED:
            self._step()
        elif outcome is MoveOutcome.FAILED and self._following is not None:
            self._following.failed(self._link.text)

    # -- following -----------------------------------------------------------------------------------------------------

    def _step(self) -> None:
        """Decide what the robot does, and do it."""
        now = self.context.elapsed()
        step = self._decide(now)
        if step.place is not None:
            self._link.drive(step.place, step.speed)
        else:
            self._link.stop()
        person = 0 if self._order is None else self._order.person
        status = FollowStatus(
            Header(), step.state, person, step.distance, step.reason, can_follow=not self._why_paused(now)
        )
        before, self._status = self._status, status
        if before is None or (before.state, before.person, before.reason) != (status.state, person, status.reason):
            self._publish_status()

    def _decide(self, now: float) -> FollowStep:
        paused = self._why_paused(now)
        following = self._following
        if self._order is None or following is None:
            return FollowStep(IDLE, paused)
        if paused:
            return FollowStep(PAUSED, paused)
        if now - self._state_at > SILENCE:
            return FollowStep(WAITING, f"the coordinator has sent nothing for {now - self._state_at:.0f} s")
        try:
            robot = self._frames.in_map()
        except TransformError as error:
            return FollowStep(WAITING, f"the pose of the robot is unknown: {error}")
        return following.step(now, robot, self._views)

    def _why_paused(self, now: float) -> str:
        """Return why the robot follows nobody now; empty if it can."""
        if now < self._paused_until:
            return f"a client has cancelled the goal; following goes on in {self._paused_until - now:.0f} s"
        if not self._link.is_free(self._parameters.resume_delay):
            return "a client has a goal for the robot" if self._link.is_heard else "Move Base has not reported yet"
        return ""

    def _publish_status(self) -> None:
        status = self._status or FollowStatus(Header(), can_follow=False)
        header = Header(stamp=Time.of(self.context.now()), frame_id=MAP)
        self.context.publish(topics.FOLLOW_STATUS.name, msgspec.structs.replace(status, header=header))

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return the number of goals, the order with the reason for giving up, and the rest of a pause, as JSON."""
        state = FollowPersonState(self._link.counter, pause=max(self._paused_until - self.context.elapsed(), 0.0))
        following = self._following
        if following is not None:
            state.order, state.gave_up, state.not_found = _key(self._order), following.gave_up, following.not_found
        return msgspec.json.encode(state)

    def restore(self, state: bytes) -> None:
        """Continue from a checkpoint; the order comes with the next message of the coordinator."""
        self._restored = restored = from_json(state, FollowPersonState)
        self._link.counter = restored.counter
        self._paused_until = self.context.elapsed() + restored.pause

    def carry_over(self, state: bytes) -> None:
        """Continue with the number of goals alone: the people of another map are not here."""
        self._link.counter = from_json(state, FollowPersonState).counter


def _key(order: FollowOrder | None) -> tuple[int, float]:
    return (0, 0.0) if order is None else (order.person, order.since.seconds())
