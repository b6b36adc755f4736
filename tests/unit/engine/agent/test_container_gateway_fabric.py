"""Topics that the containers of a map share through the container gateway."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import partial
from pathlib import Path

import pytest
from msgspec.structs import replace

from engine.agent.container_gateway import ContainerGateway
from engine.agent.fleet_topics import MAX_SHARED, MAX_WAITING
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.specs.containers import ContainerSpec, MapVersion
from storage.memory.store import MemoryStore
from tests.support.engine.attached_container import attach_container
from tests.support.engine.engine_links import receive
from tests.support.engine.fake_fabric import FakeFabric
from tests.support.engine.specs import coordinator_spec, robot_config, robot_spec, traffic_spec
from tests.support.waiting import until

Attach = Callable[[ContainerSpec], Awaitable[FrameStream[machine_link.ToContainer]]]


@pytest.fixture
def fabric() -> FakeFabric:
    return FakeFabric()


@pytest.fixture
async def gateway(tmp_path: Path, fabric: FakeFabric) -> AsyncIterator[ContainerGateway]:
    opened = ContainerGateway(tmp_path / "gate.sock", MemoryStore(), fabric, attach_timeout=5.0)
    await opened.start()
    yield opened
    await opened.close()


@pytest.fixture
def attach(gateway: ContainerGateway) -> Attach:
    return partial(attach_container, gateway)


async def test_robots_of_a_map_receive_each_other_but_not_themselves(attach: Attach) -> None:
    ann, bob = await attach(robot_spec("c1", "ann")), await attach(robot_spec("c2", "bob"))
    ann.write(machine_link.FabricPublish("amcl_pose", b"ann"))
    assert await receive(bob) == machine_link.Shared("ann", "tb1", "amcl_pose", b"ann")
    bob.write(machine_link.FabricPublish("amcl_pose", b"bob"))
    assert await receive(ann) == machine_link.Shared("bob", "tb1", "amcl_pose", b"bob")


async def test_private_topics_and_other_maps_are_not_received(attach: Attach, fabric: FakeFabric) -> None:
    ann = await attach(robot_spec("c1", "ann"))
    vault = await attach(robot_spec("c2", "bob", version=MapVersion("vault", "v1")))
    vault.write(machine_link.FabricPublish("amcl_pose", b"in the vault"))
    await until(lambda: fabric.published)
    for key in ("ppaas/bob/default/tb1/amcl_pose", "ppaas/map/house/bob/tb1/scan", "ppaas/map/house%2Fx/b/r/amcl_pose"):
        fabric.publish(key, b"secret")
    fabric.publish("ppaas/map/house/bob/tb1/amcl_pose", b"shown")
    assert await receive(ann) == machine_link.Shared("bob", "tb1", "amcl_pose", b"shown")


async def test_only_the_coordinator_of_the_same_user_and_map_receives_reports(attach: Attach) -> None:
    depot = MapVersion("depot", "v1")
    ann, bob = await attach(coordinator_spec("k1", "ann")), await attach(coordinator_spec("k2", "bob"))
    far = await attach(coordinator_spec("k3", "ann", depot))
    robots = [await attach(robot_spec(f"c{n}", user, f"tb{n}")) for n, user in enumerate(("ann", "bob", "ann"))]
    moved = await attach(robot_spec("c9", "ann", "tb9", depot))
    for robot in (*robots, moved):
        robot.write(machine_link.FabricPublish("people_tracker/report", b"seen"))
    assert {(await receive(ann)).robot for _ in range(2)} == {"tb0", "tb2"}
    assert await receive(bob) == machine_link.Shared("bob", "tb1", "people_tracker/report", b"seen")
    assert await receive(far) == machine_link.Shared("ann", "tb9", "people_tracker/report", b"seen")


async def test_robots_receive_the_state_of_their_own_coordinator_alone(attach: Attach, fabric: FakeFabric) -> None:
    topic = "people_coordinator/state"
    ann, bob = await attach(coordinator_spec("k1", "ann")), await attach(coordinator_spec("k2", "bob"))
    detector = robot_config("tb1", parameters={"torso_detector": {}})
    robot = await attach(replace(robot_spec("c1", "ann"), robot=detector))
    other = await attach(replace(robot_spec("c2", "ann", "tb2"), robot=replace(detector, id="tb2")))
    bob.write(machine_link.FabricPublish(topic, b"of bob"))
    other.write(machine_link.FabricPublish(topic, b"forged by a robot"))
    await until(lambda: len(fabric.published) == 2)
    ann.write(machine_link.FabricPublish(topic, b"of ann"))
    for one in (robot, other):
        assert await receive(one) == machine_link.Shared("ann", "_coordinator", topic, b"of ann")


async def test_only_the_traffic_node_of_the_same_user_and_map_receives_reports(attach: Attach) -> None:
    ann, bob = await attach(traffic_spec("k1", "ann")), await attach(traffic_spec("k2", "bob"))
    people = await attach(coordinator_spec("k3", "ann"))
    robots = [await attach(robot_spec(f"c{n}", user, f"tb{n}")) for n, user in enumerate(("ann", "bob", "ann"))]
    for robot in robots:
        robot.write(machine_link.FabricPublish("traffic/report", b"here"))
    assert {(await receive(ann)).robot for _ in range(2)} == {"tb0", "tb2"}
    assert await receive(bob) == machine_link.Shared("bob", "tb1", "traffic/report", b"here")
    robots[0].write(machine_link.FabricPublish("people_tracker/report", b"seen"))
    assert (await receive(people)).topic == "people_tracker/report"


async def test_each_robot_receives_the_grants_of_its_own_traffic_node_for_itself_alone(
    attach: Attach, fabric: FakeFabric
) -> None:
    topic, config = "traffic/grants", robot_config("tb1", parameters={"traffic": {}})
    ann, bob = await attach(traffic_spec("k1", "ann")), await attach(traffic_spec("k2", "bob"))
    first = await attach(replace(robot_spec("c1", "ann"), robot=config))
    second = await attach(replace(robot_spec("c2", "ann", "tb.2"), robot=replace(config, id="tb.2")))
    bob.write(machine_link.FabricPublish(topic, b"of bob", "tb1"))
    second.write(machine_link.FabricPublish(topic, b"forged by a robot", "tb1"))
    second.write(machine_link.FabricPublish(f"{topic}/tb1", b"forged by a robot"))
    await until(lambda: len(fabric.published) == 2)
    ann.write(machine_link.FabricPublish(topic, b"for all"))
    ann.write(machine_link.FabricPublish(topic, b"for tb.2", "tb.2"))
    ann.write(machine_link.FabricPublish(topic, b"for tb1", "tb1"))
    assert await receive(first) == machine_link.Shared("ann", "_traffic", topic, b"for tb1")
    assert await receive(second) == machine_link.Shared("ann", "_traffic", topic, b"for tb.2")


HOSTILE = [
    "*",
    "**",
    "amcl_pose/**",
    "$*",
    "../../bob/tb1/amcl_pose",
    "a/../../../bob/tb1/amcl_pose",
    "..",
    "",
    "/",
    "//amcl_pose",
    "amcl_pose/",
    "a b",
    "amcl_pose?x=1",
    "amcl_pose#",
    "\0",
    "a" * 1000,
    "%2e%2e/bob",
]


@pytest.mark.parametrize("topic", HOSTILE)
async def test_hostile_topic_is_refused_and_containers_stay_connected(
    attach: Attach, fabric: FakeFabric, topic: str, caplog: pytest.LogCaptureFixture
) -> None:
    ann, bob = await attach(robot_spec("c1", "ann")), await attach(robot_spec("c2", "bob"))
    for _ in range(3):
        ann.write(machine_link.FabricPublish(topic, b"evil"))
    ann.write(machine_link.FabricPublish("amcl_pose", b"good"))
    assert await receive(bob) == machine_link.Shared("ann", "tb1", "amcl_pose", b"good")
    assert fabric.published == [("ppaas/map/house/ann/tb1/amcl_pose", b"good")]
    assert len([record for record in caplog.records if record.levelname == "WARNING"]) == 1


async def test_oversized_message_is_not_shared(attach: Attach, fabric: FakeFabric) -> None:
    ann, bob = await attach(robot_spec("c1", "ann")), await attach(robot_spec("c2", "bob"))
    ann.write(machine_link.FabricPublish("amcl_pose", bytes(MAX_SHARED + 1)))
    ann.write(machine_link.FabricPublish("amcl_pose", bytes(MAX_SHARED)))
    shared = await receive(bob)
    assert isinstance(shared, machine_link.Shared)
    assert len(shared.payload) == MAX_SHARED
    assert len(fabric.published) == 1


async def test_send_buffer_of_a_slow_container_is_bounded(
    gateway: ContainerGateway, attach: Attach, fabric: FakeFabric
) -> None:
    slow = await attach(robot_spec("c1", "ann"))
    payload = bytes(MAX_SHARED)
    for _ in range(200):
        fabric.publish("ppaas/map/house/bob/tb1/amcl_pose", payload)
        await asyncio.sleep(0)
    (stream,) = gateway._streams
    assert MAX_WAITING < stream.waiting <= MAX_WAITING + 2 * MAX_SHARED
    await slow.close()


async def test_disconnected_container_is_unsubscribed(
    gateway: ContainerGateway, attach: Attach, fabric: FakeFabric
) -> None:
    stream = await attach(robot_spec("c1", "ann"))
    assert len(fabric.subscriptions) == 1
    await stream.close()
    await until(lambda: not gateway._streams)
    assert fabric.subscriptions == []


async def test_positions_that_follow_each_other_arrive_as_one_frame(attach: Attach, fabric: FakeFabric) -> None:
    ann, bob = await attach(robot_spec("c1", "ann")), await attach(robot_spec("c2", "bob"))
    for payload in (b"first", b"second", b"third"):
        fabric.publish("ppaas/map/house/eve/tb1/amcl_pose", payload)
    ann.write(machine_link.FabricPublish("amcl_pose", b"ann"))
    batch = [
        machine_link.Shared("eve", "tb1", "amcl_pose", b"third"),
        machine_link.Shared("ann", "tb1", "amcl_pose", b"ann"),
    ]
    for robot in (ann, bob):
        assert await receive(robot) == machine_link.Shared("eve", "tb1", "amcl_pose", b"first")
        assert await receive(robot) == machine_link.SharedBatch(batch)


async def test_machine_subscribes_once_to_positions_while_a_container_receives_them(
    attach: Attach, fabric: FakeFabric
) -> None:
    ann, bob = await attach(robot_spec("c1", "ann")), await attach(robot_spec("c2", "bob"))
    assert [str(each.key) for each in fabric.subscriptions] == ["ppaas/map/house/*/*/amcl_pose"]
    await ann.close()
    bob.write(machine_link.FabricPublish("amcl_pose", b"bob"))
    await until(lambda: len(fabric.published) == 1)
    assert len(fabric.subscriptions) == 1
    await bob.close()
    await until(lambda: not fabric.subscriptions)
