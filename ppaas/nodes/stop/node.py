"""Node ``stop``: holds a robot that is stopped, whatever the other nodes and the clients publish."""

from collections.abc import Callable, Sequence
from typing import ClassVar, Protocol

import msgspec

from ppaas.decoding import from_json
from ppaas.messages.base.message import Message
from ppaas.messages.geometry_msgs import Twist
from ppaas.messages.health.stops import ROBOT, RobotStop, StopRobot, StopRobotRequest, StopState
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Payload, Reply, Service, Topic
from ppaas.nodes.message_checks import expect

# -- latch -------------------------------------------------------------------------------------------------------------

LONGEST_REASON = 200
"""Length of a reason; the rest is cut off [characters]."""

BY_CLIENT = "a client of the robot"
"""Who stopped a robot by the service ``stop/request``, which any client that drives the robot may call."""


class VelocityLatch:
    """Latch through which the velocities of a clone pass: zero while the robot is stopped.

    A stop that a client of the robot requests applies at once. It is kept beside the stops of the cloud until these
    include a stop of the robot: so it is not lost if the cloud orders others before it has heard of the request.

    Parameters
    ----------
    stops : sequence of RobotStop
        Stops of the cloud that apply to the robot.

    Attributes
    ----------
    stops : tuple of RobotStop
        Stops of the cloud.
    requested : tuple of RobotStop
        Request of a client that the cloud does not have yet: one or none.
    """

    def __init__(self, stops: Sequence[RobotStop] = ()) -> None:
        self.stops = tuple(stops)
        self.requested: tuple[RobotStop, ...] = ()

    @property
    def in_force(self) -> tuple[RobotStop, ...]:
        """All stops that apply."""
        return (*self.stops, *self.requested)

    @property
    def is_stopped(self) -> bool:
        """Whether the robot is stopped."""
        return bool(self.stops or self.requested)

    def set(self, stops: Sequence[RobotStop]) -> None:
        """Replace the stops of the cloud."""
        self.stops = tuple(stops)
        if any(stop.scope == ROBOT for stop in self.stops):
            self.requested = ()

    def request(self, stop: RobotStop) -> None:
        """Stop the robot for a client, unless a stop of this robot is in force."""
        if all(other.scope != ROBOT for other in self.in_force):
            self.requested = (stop,)

    def passed(self, velocity: Payload) -> Payload:
        """Return the velocity that leaves the clone in place of one that was published."""
        return Twist() if self.is_stopped else velocity

    def state(self, changed: float) -> StopState:
        """Return the state for clients, which has not changed since a time [s since the epoch]."""
        stops = [*self.in_force]
        return StopState(bool(stops), stops, "; ".join(stop.in_words for stop in stops), changed)


# -- node --------------------------------------------------------------------------------------------------------------

PERIOD = 0.2
"""Period in which zero is published while the robot is stopped [s]: bases stop by themselves after 0.5 s at the latest,
and one that does not gets it again."""


class GatedBus(Protocol):
    """Topics of an executor, whose messages can be replaced before anybody gets them."""

    def gate(self, topic: str, gate: Callable[[Payload], Payload]) -> None:
        """Deliver on a topic what a function returns for each message, from wherever it comes."""
        ...


class StopNode(Node):
    """Stops the robot as the cloud orders, or a client requests.

    It gates two topics of the clone. On ``cmd_vel`` nothing but zero passes while the robot is stopped: from
    Move Base, from clients, from bridges. On ``stop/state`` nothing passes but the state itself.

    Parameters
    ----------
    context : Context
        The node's context.
    bus : GatedBus
        Topics of the clone.
    robot : str
        Robot ID.
    stops : sequence of RobotStop
        Stops that apply from the beginning.

    Attributes
    ----------
    changed : callable
        Called after each change of the stops in force, also if they are set to the same.
    """

    name: ClassVar[str] = "stop"
    publishes: ClassVar[tuple[Topic, ...]] = (topics.STOP_STATE, topics.CMD_VEL)
    services: ClassVar[tuple[Service, ...]] = (Service("stop/request", StopRobot),)

    def __init__(self, context: Context, bus: GatedBus, robot: str, stops: Sequence[RobotStop] = ()) -> None:
        super().__init__(context)
        self.latch = VelocityLatch(stops)
        self.changed: Callable[[], None] = lambda: None
        self._robot = robot
        self._changed_at = context.now()
        bus.gate(topics.CMD_VEL.name, self.latch.passed)
        bus.gate(topics.STOP_STATE.name, lambda _: self._state())

    def start(self) -> None:
        """Publish the state, and zero again and again while the robot is stopped."""
        self._tell()
        self.context.every(PERIOD, self._repeat)

    def set(self, stops: Sequence[RobotStop]) -> None:
        """Replace the stops of the cloud that apply to the robot."""
        self.latch.set(stops)
        self._tell()

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Stop the robot for a client; it is released in the cloud, by somebody with a name."""
        reason = expect(request, StopRobotRequest).reason[:LONGEST_REASON]
        self.latch.request(RobotStop(ROBOT, self._robot, BY_CLIENT, self.context.now(), reason))
        self._tell()
        reply(self._state())

    def _state(self) -> StopState:
        return self.latch.state(self._changed_at)

    def _tell(self) -> None:
        """Send zero first, then what the robot waits for."""
        self._changed_at = self.context.now()
        self._repeat()
        self.context.publish(topics.STOP_STATE.name, self._state())
        self.changed()

    def _repeat(self) -> None:
        if self.latch.is_stopped:
            self.context.publish(topics.CMD_VEL.name, Twist())

    def checkpoint(self) -> bytes:
        """Return the stops in force, and the request that the cloud does not have yet, as JSON."""
        return msgspec.json.encode(self.latch.requested)

    def restore(self, state: bytes) -> None:
        """Continue with a request that the cloud did not have yet; its own stops come with the container."""
        for stop in from_json(state, tuple[RobotStop, ...]):
            self.latch.request(stop)
        self._tell()
