"""What passes between the local node manager and the process that its nodes run in: lines of JSON on its pipes."""

import msgspec

from ppaas.robot_model.description import RobotDescription


class CloneConfig(msgspec.Struct, frozen=True):
    """What the nodes of a clone are made of, as the node monitor of the cloud tells it."""

    model: str
    initial_pose: tuple[float, float, float]
    base_global_planner: str
    base_local_planner: str
    parameters: dict[str, dict[str, object]] = {}
    urdf: RobotDescription | None = None


class TopicName(msgspec.Struct, frozen=True):
    """A topic and its ROS type."""

    name: str
    type: str


class ServiceName(msgspec.Struct, frozen=True):
    """A service and its ROS type."""

    name: str
    type: str


# -- to the process ----------------------------------------------------------------------------------------------------


class Begin(msgspec.Struct, tag="begin"):
    """Get ready for nodes on a map and its masks, by the services that give them; each ``nav_msgs/OccupancyGrid``."""

    config: CloneConfig
    map: msgspec.Raw
    masks: dict[str, msgspec.Raw] = {}


class Add(msgspec.Struct, tag="add"):
    """Let a node go on here from its checkpoint."""

    node: str
    state: str


class Remove(msgspec.Struct, tag="remove"):
    """Let a node leave."""

    node: str


class Tell(msgspec.Struct, tag="tell"):
    """A message for the nodes, or for one alone."""

    topic: str
    payload: msgspec.Raw
    node: str = ""


class AskStates(msgspec.Struct, tag="ask_states"):
    """Say how the nodes are."""


class Call(msgspec.Struct, tag="call"):
    """A call of a service of a node; several may be under way, and each is answered by its number."""

    call: int
    service: str
    request: msgspec.Raw


ToHome = Begin | Add | Remove | Tell | AskStates | Call

# -- from the process --------------------------------------------------------------------------------------------------


class Ready(msgspec.Struct, tag="ready"):
    """Nodes may come."""


class Added(msgspec.Struct, tag="added"):
    """A node is here: what it hears, what it says, and what it can be asked."""

    node: str
    subscribes: list[TopicName]
    publishes: list[str]
    services: list[ServiceName] = []


class Removed(msgspec.Struct, tag="removed"):
    """A node has left, and this is its checkpoint."""

    node: str
    state: str


class Said(msgspec.Struct, tag="said"):
    """A node here has published something."""

    topic: str
    kind: str
    payload: msgspec.Raw


class Replied(msgspec.Struct, tag="replied"):
    """What came of a call: the response, or an error by its slug and text."""

    call: int
    response: msgspec.Raw = msgspec.Raw(b"null")
    slug: str = ""
    text: str = ""


class NodeState(msgspec.Struct):
    """How a node is: its checkpoint, and what it took in the mean for each thing that it was told [s]."""

    state: str
    seconds: float = 0.0


class States(msgspec.Struct, tag="states"):
    """How the nodes are, by their names."""

    nodes: dict[str, NodeState]


class Failed(msgspec.Struct, tag="failed"):
    """What was asked for last cannot be done, by the slug of an error and its text."""

    slug: str
    text: str


Answer = Ready | Added | Removed | States | Failed
FromHome = Answer | Said | Replied

to_home = msgspec.json.Decoder(ToHome)
from_home = msgspec.json.Decoder(FromHome)
_encoder = msgspec.json.Encoder()


def line(frame: ToHome | FromHome) -> bytes:
    """Return a frame as a line."""
    return _encoder.encode(frame) + b"\n"


MAX_LINE = 1 << 28
"""Bytes; a map is the longest there is."""
