"""Qualities of service and endpoints of DDS as ROS has them."""

import re
from types import SimpleNamespace
from typing import Any

from ppaas.distribution import check_versions, install_hint
from ppaas.errors import InvalidInput, MalformedMessage
from ppaas.wire.ros.graph import Entity, Kind, Qos
from ppaas.wire.ros.rmw_zenoh import ros_type

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
