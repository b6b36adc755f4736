"""Places without sockets, with sessions or as an endpoint sees them, whose clone is played by the test."""

import itertools
import json
from collections.abc import Callable
from typing import Any

import cbor2
import msgspec

from engine.links.open_calls import Outcome
from engine.links.place_link import PlaceLink
from engine.protocols import refusals, robot_link
from engine.protocols.session_frames import NumberedFrame
from engine.rights.access import Access
from engine.rights.roles import Role
from engine.sessions.place.clone import CloneListener
from engine.sessions.place.place import Place
from engine.sessions.session import ClientSession
from ppaas.errors import PPaaSError
from ppaas.wire.binary.packing import Packer
from ppaas.wire.names import NameScope
from ppaas.wire.ros.serialization import serialize
from ppaas.wire.rosbridge import RosbridgeSession
from tests.support.engine.engine_links import HELLO_NODES, HELLO_SERVICES, HELLO_TOPICS
from tests.support.network.still_socket import BINARY, sent
from tests.support.waiting import until

TOPICS = [
    *HELLO_TOPICS,
    robot_link.TopicInfo("move_base/goal", "move_base_msgs/MoveBaseActionGoal", False),
    robot_link.TopicInfo("move_base/cancel", "actionlib_msgs/GoalID", False),
    robot_link.TopicInfo("move_base/status", "actionlib_msgs/GoalStatusArray", False),
    robot_link.TopicInfo("move_base/feedback", "move_base_msgs/MoveBaseActionFeedback", False),
    robot_link.TopicInfo("move_base/result", "move_base_msgs/MoveBaseActionResult", False),
]

POSE = {
    "header": {"frame_id": "map"},
    "pose": {"position": {"x": 1.0, "y": 2.0}, "orientation": {"z": 0.0, "w": 1.0}},
}


class StillStream:
    """Near end of a robot link: records written frames."""

    waiting = 0

    def __init__(self) -> None:
        self.written: list[robot_link.ToContainer] = []

    def write(self, frame: robot_link.ToContainer) -> None:
        self.written.append(frame)

    def take(self, kind: type[msgspec.Struct]) -> list[Any]:
        """Return the frames of a kind written since the last call."""
        found = [frame for frame in self.written if isinstance(frame, kind)]
        self.written = [frame for frame in self.written if not isinstance(frame, kind)]
        return found


class StillClone(StillStream):
    """Clone that records what it is given, as frames of the robot link; the test answers by them, too."""

    def __init__(self) -> None:
        super().__init__()
        self.replies: dict[int, Callable[[Outcome], None]] = {}

    def topics(self) -> list[robot_link.TopicInfo]:
        return [*TOPICS]

    def services(self) -> list[robot_link.ServiceInfo]:
        return [*HELLO_SERVICES]

    def nodes(self) -> list[robot_link.NodeInfo]:
        return [*HELLO_NODES]

    def add_listener(self, listener: CloneListener) -> None:
        """Tell nobody by itself: the test does, by the place."""

    def subscribe(self, listener: CloneListener, topic: str, client: int) -> None:
        self.write(robot_link.SubscribeTopic(topic, client))

    def unsubscribe(self, topic: str) -> None:
        self.write(robot_link.UnsubscribeTopic(topic))

    def deliver(self, topic: str, payload: bytes, client: int, sequence: int) -> PPaaSError | None:
        self.write(robot_link.Deliver(topic, payload, client, sequence))
        return None

    def call(self, service: str, payload: bytes, reply: Callable[[Outcome], None]) -> None:
        number = len(self.replies) + 1
        self.replies[number] = reply
        self.write(robot_link.ServiceCall(number, service, payload))


class StillPlace(Place):
    """Place that has a clone from the start, without a queue: its clients hear at once what the test says."""

    def __init__(self, clone: StillClone | None = None, key: str = "robot:ann/tb1") -> None:
        super().__init__(key)
        self.far = clone or StillClone()
        self.begin(self.far)

    def say(self, frame: robot_link.FromContainer) -> None:
        """Pass on at once what the clone says, as the frame that it would be on a robot link."""
        match frame:
            case robot_link.Published():
                self._published(frame.topic, frame.payload, frame.client or 0)
            case robot_link.TopicAdded():
                self._topic_added(frame.topic, frame.node)
            case robot_link.TopicRemoved():
                self._topic_removed(frame.name)
            case robot_link.NodesChanged():
                self._nodes_changed(frame.services, frame.nodes)
            case robot_link.MapReplaced():
                self._map_replaced()
            case robot_link.Ack():
                self._acknowledged(frame.sequence)
            case robot_link.MessageRefused():
                self._refused(frame.client, frame.topic, refusals.error_of(frame.refusal), frame.sequence)
            case robot_link.ServiceAnswer() if frame.call in self.far.replies:
                self.far.replies[frame.call](refusals.error_of(frame.refusal) if frame.refusal else frame.payload)
                self._pass_on()

    def publish_json(self, topic: str, message: Any) -> None:
        """Deliver a message published by the clone."""
        self.say(robot_link.Published(topic, json.dumps(message).encode()))


class StillRobot(PlaceLink):
    """Place as an endpoint or the master sees it, whose container is played by the test."""

    def __init__(self, key: str = "robot:ann/tb1") -> None:
        super().__init__(key)
        self.far = StillStream()
        self.begin(robot_link.Hello("c1", "", 7, 0, TOPICS, HELLO_SERVICES, HELLO_NODES), self.far)

    def say(self, frame: robot_link.FromContainer) -> None:
        """Deliver a frame of the container."""
        self.take(frame)

    def publish_json(self, topic: str, message: Any) -> None:
        """Deliver a message published by the container."""
        self.say(robot_link.Published(topic, json.dumps(message).encode()))


class StillClient:
    """Client session without a socket."""

    def __init__(
        self,
        place: Place,
        role: Role = "robot",
        level: str = "info",
        count_plan: Callable[[], None] = lambda: None,
        names: NameScope | None = None,
    ) -> None:
        wire = RosbridgeSession(level, names, Packer(serialize=serialize))  # type: ignore[arg-type]
        self.session = ClientSession(place, role, wire, role, count_plan, access=Access.of_owner("tb1"))
        self._numbers = itertools.count(1)

    def say(self, **frame: Any) -> None:
        """Send a frame."""
        self.send(json.dumps(frame))

    def send(self, content: str | bytes) -> None:
        """Send the content of a frame, ``bytes`` for a binary one."""
        binary = isinstance(content, bytes)
        body = content if isinstance(content, bytes) else content.encode(errors="replace")
        self.session.take(NumberedFrame(next(self._numbers), body, binary))
        self.session.release()  # without waiting for the types of ROS

    def received(self) -> list[dict[str, Any]]:
        """Return the frames sent to the client since the last call."""
        return [_operation_in(frame) for frame in sent(self.session.outbox)]


def _operation_in(frame: str) -> dict[str, Any]:
    """Return the operation in a frame of JSON, or of CBOR, in which typed arrays stay tagged."""
    operation: dict[str, Any] = json.loads(frame) if frame.startswith("{") else cbor2.loads(frame.encode(errors=BINARY))
    return operation


async def answers(client: StillClient, count: int = 1) -> list[dict[str, Any]]:
    """Wait until ``count`` frames have been sent."""
    await until(lambda: len(client.session.outbox) >= count)
    return client.received()


def says(client: StillClient, **frame: Any) -> list[dict[str, Any]]:
    """Send a frame of a client, and return what the cloud sends it."""
    client.say(**frame)
    return client.received()


def error_of(frames: list[dict[str, Any]], slug: str = "malformed-message") -> dict[str, Any]:
    """Return the only frame, which must be an error with this slug."""
    [frame] = frames
    assert (frame["op"], frame["level"]) == ("status", "error")
    assert frame["msg"].startswith(f"{slug}: "), frame["msg"]
    return frame


def delivered(place: StillPlace | StillRobot) -> list[tuple[str, Any]]:
    """Return the messages sent to the container since the last call: topics, and messages as values of JSON."""
    return [(message.topic, json.loads(message.payload)) for message in place.far.take(robot_link.Deliver)]
