"""The transport over DDS on the loopback interface, with types that Cyclone DDS codes itself."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import int8, int32, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from ppaas.errors import InvalidInput, Unavailable
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import LATCHED, SENSOR, Kind
from robots.bridges.dds import node as node_module
from robots.bridges.dds.cyclone import IdlTypes
from robots.bridges.dds.node import DdsOptions, DdsTransport
from tests.support.waiting import until

DOMAIN = 101
UPDATE = "map_msgs/msg/OccupancyGridUpdate"


@dataclass
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs.msg.dds_.Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Update(IdlStruct, typename="map_msgs.msg.dds_.OccupancyGridUpdate_"):
    header: Header
    x: int32
    y: int32
    width: uint32
    height: uint32
    data: sequence[int8]


WRITTEN = Update(Header(Time(3, 4), "map"), -1, 2, 3, 1, [0, 100, -1])
RELIABLE = Policy.Reliability.Reliable(duration(seconds=1))


@pytest.fixture(autouse=True)
def _on_this_computer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setattr(node_module, "GRAPH_WAIT", 0.05)


@asynccontextmanager
async def opened(release: str = "jazzy") -> AsyncIterator[DdsTransport]:
    transport = DdsTransport(DdsOptions(DOMAIN, release))
    await transport.open(lambda: None)
    try:
        yield transport
    finally:
        await transport.close()


async def test_topics_pass_both_ways_and_the_graph_is_that_of_ros() -> None:
    async with opened() as transport:
        peer = DomainParticipant(DOMAIN)
        topic = Topic(peer, "rt/map_updates", Update)
        late_topic = Topic(peer, "rt/latched", Update)
        writers = [DataWriter(peer, topic, qos=Qos(Policy.Reliability.BestEffort))]
        heard: list[dict[str, object]] = []
        subscription = transport.subscribe(
            "/map_updates", UPDATE, SENSOR, lambda data: heard.append(transport.types.decode(UPDATE, data))
        )
        await until(lambda: [one.name for one in transport.entities()] == ["/map_updates"])
        [found] = transport.entities()
        assert (found.kind, found.type, found.qos.reliable, found.qos.latched) == (Kind.PUBLISHER, UPDATE, False, False)

        def written() -> object:
            writers[0].write(WRITTEN)
            return heard

        await until(written)
        assert heard[0]["header"] == {"stamp": {"sec": 3, "nanosec": 4}, "frame_id": "map"}
        assert (heard[0]["x"], list(heard[0]["data"])) == (-1, [0, 100, -1])  # type: ignore[call-overload]

        latched = transport.publisher("/latched", UPDATE, LATCHED)
        latched.publish(transport.types.encode(UPDATE, heard[0]))
        reader = DataReader(peer, late_topic, qos=Qos(RELIABLE, Policy.Durability.TransientLocal))
        received: list[Update] = []

        def taken() -> object:
            received.extend(sample for sample in reader.take(N=10) if isinstance(sample, Update))
            return received

        await until(taken)
        assert received[0] == WRITTEN
        subscription.close()
        writers.clear()
        await until(lambda: [one.name for one in transport.entities()] == ["/latched"])
        assert not transport.services
        assert "goal_pose" in transport.lacking
        with pytest.raises(Unavailable, match=f"DDS cannot be opened in domain {DOMAIN}"):
            await DdsTransport(DdsOptions(DOMAIN)).open(lambda: None)


async def test_a_configuration_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="cannot be read"):
        await DdsTransport(DdsOptions(DOMAIN, config=tmp_path / "none.xml")).open(lambda: None)


@pytest.mark.parametrize("release", ["humble", "kilted"])
def test_types_have_the_names_and_fields_of_ros(release: str) -> None:
    idl = IdlTypes(ros_types(release))
    info = idl.of("rmw_dds_common/msg/ParticipantEntitiesInfo")
    assert info.__idl_typename__ == "rmw_dds_common.msg.dds_.ParticipantEntitiesInfo_"
    gid = idl.of("rmw_dds_common/msg/Gid")
    assert str(24 if release == "humble" else 16) in repr(gid.__annotations__["data"])
    assert idl.of("nav_msgs/msg/Odometry") is idl.of("nav_msgs/msg/Odometry")
