"""Cyclone DDS for nodes of ROS 2: discovery, types of messages, and qualities of service.

Variables of ROS 2 that the configuration of discovery follows:

================================  =====================================================================================
variable                          effect
================================  =====================================================================================
``ROS_LOCALHOST_ONLY=1``          this computer alone; the other two variables are ignored
``ROS_AUTOMATIC_DISCOVERY_RANGE`` ``SUBNET`` (the default): nodes that multicast reaches; ``LOCALHOST``: nodes on this
                                  computer; ``OFF``: none; ``SYSTEM_DEFAULT``: as Cyclone DDS does it, without peers
``ROS_STATIC_PEERS``              addresses, separated by ``;``, at which nodes are looked for besides
``ROS_DISCOVERY_SERVER``          refused: the server is of Fast DDS, and Cyclone DDS finds no nodes by it
================================  =====================================================================================

Source: ``rcl/discovery_options.h`` of ``ros2/rcl``, and "Improved Dynamic Discovery" on docs.ros.org.
"""

import ipaddress
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace, new_class
from typing import Any
from xml.sax.saxutils import quoteattr

from ppaas.distribution import check_versions, install_hint
from ppaas.errors import InvalidInput, MalformedMessage
from ppaas.wire.ros import RosTypes
from ppaas.wire.ros.graph import Entity, Kind, Qos
from ppaas.wire.ros.rmw_zenoh import ros_type

RANGE, PEERS, LOCALHOST_ONLY = "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"
SERVER = "ROS_DISCOVERY_SERVER"
RANGES = ("SUBNET", "LOCALHOST", "SYSTEM_DEFAULT", "OFF")

_COMPATIBLE = "<Compatibility><IgnoreTypeInformation>1.15</IgnoreTypeInformation></Compatibility>"
"""1.15 is eProsima: without this no type with an array or a list matches Fast DDS 3 (Kilted and newer)."""

_LOOPBACK = '<Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>'


def cyclone_configuration(environment: Mapping[str, str]) -> str:
    """Return the configuration of Cyclone DDS (XML) that the variables ask for.

    Raises
    ------
    InvalidInput
        The range is ``OFF``, in which a bridge finds no robot, or is none of ROS; or there is a discovery server.
    """
    if environment.get(SERVER, "").strip(";"):
        raise InvalidInput(
            f"{SERVER} names a discovery server of Fast DDS, by which Cyclone DDS finds no nodes: take --transport "
            f"rclpy where ROS 2 is installed; or unset it here and for the robot's nodes, and name the robot's "
            f"computer in {PEERS} if multicast does not reach it"
        )
    wanted = environment.get(RANGE) or "SUBNET"
    peers = [peer for text in environment.get(PEERS, "").split(";") if (peer := text.strip())]
    if environment.get(LOCALHOST_ONLY) == "1":
        wanted, peers = "LOCALHOST", []
    if wanted not in RANGES:
        raise InvalidInput(f"{RANGE} must be one of {', '.join(RANGES)}, not {wanted!r}")
    if wanted == "OFF":
        raise InvalidInput(f"{RANGE}=OFF keeps the bridge from finding any robot: set SUBNET or LOCALHOST")
    if wanted == "LOCALHOST":
        # The loopback interface has no multicast; nodes of this computer are found by the ports of their participants.
        interfaces = "" if any(map(_is_remote, peers)) else _LOOPBACK
        general = f"<General>{interfaces}<AllowMulticast>false</AllowMulticast></General>"
        return _domain(general + _discovery(["localhost", *peers]))
    return _domain(_discovery(peers) if peers and wanted == "SUBNET" else "")


def _domain(content: str) -> str:
    return f"<CycloneDDS><Domain>{content}{_COMPATIBLE}</Domain></CycloneDDS>"


def _discovery(peers: Sequence[str]) -> str:
    listed = "".join(f"<Peer address={quoteattr(peer)}/>" for peer in peers)
    index = "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    return f"<Discovery>{index}<Peers>{listed}</Peers></Discovery>"


def _is_remote(peer: str) -> bool:
    """Return whether a peer may be another computer: it is no loopback address."""
    try:
        return not ipaddress.ip_address(peer).is_loopback
    except ValueError:
        return peer != "localhost"


# -- types of messages as Cyclone DDS has them -------------------------------------------------------------------------


class IdlTypes:
    """Classes of IDL for the messages of a release.

    Parameters
    ----------
    types : RosTypes
        Types of the release.
    """

    def __init__(self, types: RosTypes) -> None:
        from cyclonedds.idl import IdlStruct  # noqa: PLC0415 - of the extra ros2
        from cyclonedds.idl import types as idl  # noqa: PLC0415

        self._types, self._struct, self._idl = types, IdlStruct, idl
        self._classes: dict[str, Any] = {}

    def of(self, name: str) -> Any:
        """Return the class of a message, given its full name such as ``nav_msgs/msg/Path``."""
        if name not in self._classes:
            package, folder, short = name.split("/")
            annotations = {field.name: self._field(field) for field in self._types.fields(name)}
            body = {"__annotations__": annotations, "__module__": __name__}
            typename = f"{package}.{folder}.dds_.{short}_"
            created = new_class(f"{short}_", (self._struct,), {"typename": typename}, lambda space: space.update(body))
            self._classes[name] = dataclass(created)
        return self._classes[name]

    def _field(self, field: Any) -> Any:
        idl = self._idl
        if field.type == "string":
            single = idl.bounded_str[field.text_bound] if field.text_bound else str
        elif field.type == "bool":
            single = bool
        elif field.type in ("byte", "char"):
            single = idl.uint8
        else:
            single = self.of(field.type) if "/" in field.type else getattr(idl, field.type)
        if field.length is None:
            return single
        if field.length:
            return idl.array[single, field.length]
        return idl.sequence[single, field.bound] if field.bound else idl.sequence[single]


# -- qualities of service and endpoints of DDS as ROS has them ---------------------------------------------------------

BLOCKING = 0.1
"""Longest time that a write waits for slow readers [s]."""

_HASH = re.compile(rb"typehash=(RIHS01_[0-9a-f]{64});")


def imported() -> Any:
    """Return the names of ``cyclonedds`` that are used.

    Raises
    ------
    InvalidInput
        It is not installed; the text says how to install it.
    Unavailable
        A package of the extra is older or newer than tried.
    """
    check_versions("ros2")
    try:
        from cyclonedds import _clayer, builtin, core, domain, pub, sub, topic, util  # noqa: PLC0415 - of the extra ros2
    except ImportError as error:
        raise InvalidInput(f"robots with DDS need the extra ros2: {install_hint('ros2')}") from error
    return SimpleNamespace(
        write=_clayer.ddspy_write,
        take=_clayer.ddspy_take,
        ANY=0x7F,
        BuiltinDataReader=builtin.BuiltinDataReader,
        publications=builtin.BuiltinTopicDcpsPublication,
        subscriptions=builtin.BuiltinTopicDcpsSubscription,
        DDSException=core.DDSException,
        InstanceState=core.InstanceState,
        Policy=core.Policy,
        Qos=core.Qos,
        WaitSet=core.WaitSet,
        condition=lambda reader: core.ReadCondition(
            reader, core.ViewState.Any | core.InstanceState.Any | core.SampleState.NotRead
        ),
        Domain=domain.Domain,
        DomainParticipant=domain.DomainParticipant,
        DataWriter=pub.DataWriter,
        DataReader=sub.DataReader,
        Topic=topic.Topic,
        duration=util.duration,
    )


def of(dds: Any, qos: Qos, type_hash: str) -> Any:
    """Return the quality of service of an endpoint; its user data have the hash of the type, as ROS has it."""
    policy = dds.Policy
    return dds.Qos(
        policy.Reliability.Reliable(dds.duration(seconds=BLOCKING)) if qos.reliable else policy.Reliability.BestEffort,
        policy.Durability.TransientLocal if qos.latched else policy.Durability.Volatile,
        policy.History.KeepLast(qos.depth),
        policy.Userdata(f"typehash={type_hash};".encode()),
    )


def is_alive(dds: Any, sample: Any) -> bool:
    """Return whether an endpoint of the graph is there; else it has left."""
    return bool(sample.sample_info.instance_state == dds.InstanceState.Alive)


def entity_of(dds: Any, kind: Kind, sample: Any) -> Entity | None:
    """Return the entity of an endpoint; None if it is not a topic of ROS."""
    if not sample.topic_name.startswith("rt/"):
        return None
    try:
        type_name = ros_type(sample.type_name)
    except MalformedMessage:
        return None
    policy, qos = dds.Policy, sample.qos
    reliability, durability = qos[policy.Reliability], qos[policy.Durability]
    depth = getattr(qos[policy.History], "depth", 1)
    found = _HASH.search(qos[policy.Userdata].data) if qos[policy.Userdata] is not None else None
    return Entity(
        kind,
        sample.topic_name.removeprefix("rt"),
        type_name,
        Qos(reliability != policy.Reliability.BestEffort, durability != policy.Durability.Volatile, depth),
        "",
        str(sample.key),
        found[1].decode() if found else "",
    )
