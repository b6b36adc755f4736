"""Leases of nodes that the robot runs, with the messages that they lack, and the node monitor's record of each node."""

from collections.abc import Collection

import msgspec

from engine.container.monitor.facts import Home
from engine.container.monitor.measurements import History
from ppaas.messages import encode
from ppaas.messages.base.message import Message
from ppaas.messages.ppaas_msgs import TopicMessage
from ppaas.nodes.base import Payload
from ppaas.nodes.message_checks import fingerprint
from ppaas.nodes.topics import policy_of

MOST = 100
"""Largest number of messages kept for one node; beyond it the oldest are dropped."""


class UnacknowledgedMessages(msgspec.Struct):
    """Unacknowledged messages for one node by their fingerprints, oldest first."""

    messages: dict[str, TopicMessage] = {}

    def note(self, topic: str, payload: Payload) -> None:
        """Keep a message for the node; of a latched topic, only the last one."""
        message = payload if isinstance(payload, Message) else payload.to_message()
        mark = fingerprint(topic, message)
        if policy_of(topic).latched and policy_of(topic).merge is None:
            self.messages = {known: each for known, each in self.messages.items() if each.topic != topic}
        self.messages.pop(mark, None)  # sent again: now the newest
        self.messages[mark] = TopicMessage(topic, encode(message).decode())
        while len(self.messages) > MOST:
            del self.messages[next(iter(self.messages))]

    def heard(self, fingerprints: Collection[str]) -> None:
        """Drop the messages that the robot's last checkpoint includes."""
        for mark in fingerprints:
            self.messages.pop(mark, None)

    def has(self, topic: str) -> bool:
        """Return whether a message on a topic is kept."""
        return any(each.topic == topic for each in self.messages.values())

    def all(self) -> list[TopicMessage]:
        """Return the kept messages, oldest first."""
        return list(self.messages.values())


class GrantedLease(msgspec.Struct):
    """Lease by which the robot runs a node.

    Parameters
    ----------
    number : int
        Number of the lease, unique for the clone.
    state : str
        The node's last checkpoint.
    heard : float
        Time of the robot's last report that it runs the node [monotonic s].
    unheard : UnacknowledgedMessages
        Messages for the node that are not yet part of that checkpoint.
    """

    number: int
    state: str
    heard: float
    unheard: UnacknowledgedMessages = msgspec.field(default_factory=UnacknowledgedMessages)


class HomeRecord(msgspec.Struct):
    """Node monitor's record of one node.

    Parameters
    ----------
    wanted : {"cloud", "robot"}
        Home in which the node should run.
    score, reasons
        Score and reasons of the verdict for that home.
    lease : GrantedLease, optional
        Lease of the robot; None while the node runs in the cloud.
    cloud_seconds, robot_seconds : History
        Times to process one input in either home [s].
    failure : str
        Reason of the last failure on the robot.
    failed : float
        Time of that failure [s since the epoch].
    adrift : bool
        Whether the robot ran it when the lease expired, and has not been heard of since: it may run it still.
    """

    wanted: Home = "cloud"
    score: float = 1.0
    reasons: tuple[str, ...] = ("no client has requested it yet",)
    lease: GrantedLease | None = None
    cloud_seconds: History = msgspec.field(default_factory=History)
    robot_seconds: History = msgspec.field(default_factory=History)
    failure: str = ""
    failed: float = 0.0
    adrift: bool = False

    @property
    def home(self) -> Home:
        """Home in which the node runs."""
        return "cloud" if self.lease is None else "robot"
