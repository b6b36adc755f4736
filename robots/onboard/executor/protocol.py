"""Protocol between the local node manager and the executor process: lines of JSON on its pipes."""

import msgspec

from ppaas.robot_model.description import RobotDescription


class CloneConfig(msgspec.Struct, frozen=True):
    """Configuration of a clone's nodes, as the node monitor sends it."""

    model: str
    initial_pose: tuple[float, float, float]
    base_global_planner: str
    base_local_planner: str
    parameters: dict[str, dict[str, object]] = {}
    urdf: RobotDescription | None = None
    new_map: str = ""
    id: str = "robot"


LogRow = tuple[int, bytes]
"""Entry of the log of a node: its number and its data."""


class TopicName(msgspec.Struct, frozen=True):
    """A topic and its ROS type."""

    name: str
    type: str


class ServiceName(msgspec.Struct, frozen=True):
    """A service and its ROS type."""

    name: str
    type: str


# -- commands to the executor ------------------------------------------------------------------------------------------


class Begin(msgspec.Struct, tag="begin"):
    """Prepare for nodes on a map and its masks, by the service of each mask; all are ``nav_msgs/OccupancyGrid``.

    There is none if the robot makes a new map. Zones are the map's, as GeoJSON; empty for none.
    """

    config: CloneConfig
    map: msgspec.Raw = msgspec.Raw(b"null")
    masks: dict[str, msgspec.Raw] = {}
    zones: str = ""


class Add(msgspec.Struct, tag="add"):
    """Add a node, and restore its checkpoint and its log."""

    node: str
    state: str
    log: list[LogRow] = []


class Remove(msgspec.Struct, tag="remove"):
    """Remove a node."""

    node: str


class Tell(msgspec.Struct, tag="tell"):
    """Deliver a message to all nodes, or to the one named."""

    topic: str
    payload: msgspec.Raw
    node: str = ""


class AskStates(msgspec.Struct, tag="ask_states"):
    """Request the states of all nodes."""


class NodeCall(msgspec.Struct, tag="call"):
    """Call a service of a node. Several calls may be in progress; the reply has the number of its call."""

    call: int
    service: str
    request: msgspec.Raw


ToExecutor = Begin | Add | Remove | Tell | AskStates | NodeCall

# -- answers and messages of the executor ------------------------------------------------------------------------------


class ExecutorReady(msgspec.Struct, tag="ready"):
    """The executor is ready for nodes."""


class Added(msgspec.Struct, tag="added"):
    """A node was added: the topics that it subscribes and publishes, and its services."""

    node: str
    subscribes: list[TopicName]
    publishes: list[str]
    services: list[ServiceName] = []


class Removed(msgspec.Struct, tag="removed"):
    """A node was removed, with its last checkpoint, and what its log has added and removed since the last states."""

    node: str
    state: str
    log: list[LogRow] = []
    obsolete: list[int] = []


class Said(msgspec.Struct, tag="said"):
    """A node has published a message."""

    topic: str
    kind: str
    payload: msgspec.Raw


class Replied(msgspec.Struct, tag="replied"):
    """Result of a call: the response, or the slug and text of an error."""

    call: int
    response: msgspec.Raw = msgspec.Raw(b"null")
    slug: str = ""
    text: str = ""


class NodeReport(msgspec.Struct):
    """State of a node: its checkpoint, its mean time to process a message [s], and the change of its log since then."""

    state: str
    seconds: float = 0.0
    log: list[LogRow] = []
    obsolete: list[int] = []


class States(msgspec.Struct, tag="states"):
    """States of the nodes, by name."""

    nodes: dict[str, NodeReport]


class NodeFailed(msgspec.Struct, tag="failed"):
    """The last command failed, with the slug and text of an error."""

    slug: str
    text: str


Answer = ExecutorReady | Added | Removed | States | NodeFailed
FromExecutor = Answer | Said | Replied

to_executor = msgspec.json.Decoder(ToExecutor)
from_executor = msgspec.json.Decoder(FromExecutor)
_encoder = msgspec.json.Encoder()


def line(frame: ToExecutor | FromExecutor) -> bytes:
    """Encode a frame as a line of JSON."""
    return _encoder.encode(frame) + b"\n"


MAX_LINE = 1 << 28
"""Longest line [bytes]; maps are the longest frames."""
