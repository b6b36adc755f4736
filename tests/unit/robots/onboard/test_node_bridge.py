"""Topics and services of local nodes."""

import asyncio
from typing import Any

import msgspec
import pytest

from ppaas.errors import Conflict, Unavailable
from ppaas.messages import ServiceType, decode, encode
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.ppaas_msgs import TopicMessage
from ppaas.messages.sensor_msgs import Image
from ppaas.messages.std_srvs import Trigger, TriggerResponse
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.message_checks import fingerprint
from ppaas.nodes.topics import TOPICS
from robots.client.services import Handler
from robots.onboard.executor import protocol
from robots.onboard.node_bridge import NodeServices, TopicBridge
from robots.onboard.node_manager import SENSORS

FAST = Twist(Vector3(x=0.5))
TF = protocol.TopicName("tf", "tf2_msgs/TFMessage")
ODOM = protocol.TopicName("odom", "nav_msgs/Odometry")


class FakeClient:
    """Records calls, and delivers messages to its subscribers."""

    def __init__(self) -> None:
        self.subscriptions: dict[str, Any] = {}
        self.sent: list[tuple[str, Message, bool]] = []
        self.heard: list[str] = []

    async def subscribe(self, topic: str, kind: type[Message], callback: Any) -> str:
        self.subscriptions[topic] = lambda payload: callback(decode(kind, payload))
        return topic

    async def unsubscribe(self, topic: str) -> None:
        del self.subscriptions[topic]

    async def publish(self, topic: str, message: Message, *, newest_only: bool) -> None:
        self.sent.append((topic, message, newest_only))

    def deliver(self, topic: str, payload: msgspec.Raw) -> None:
        self.heard.append(topic)
        if topic in self.subscriptions:
            self.subscriptions[topic](payload)


class FakeProcess:
    """Records the messages for its nodes."""

    def __init__(self) -> None:
        self.delivered: list[str] = []
        self.delivered_to_node: list[tuple[str, str]] = []

    def tell(self, topic: str, payload: bytes, node: str = "") -> None:
        if node:
            self.delivered_to_node.append((node, decode(MoveBaseActionGoal, payload).goal_id.id))
        else:
            self.delivered.append(topic)


class FakeLatch:
    """Replaces velocities while the robot is stopped."""

    stopped = False

    def passed(self, topic: str, payload: msgspec.Raw) -> msgspec.Raw:
        return msgspec.Raw(encode(Twist())) if self.stopped and topic == "cmd_vel" else payload


LATCH = FakeLatch()


async def bridge(*nodes: protocol.Added, latch: FakeLatch = LATCH) -> tuple[TopicBridge, FakeClient, FakeProcess]:
    client, process = FakeClient(), FakeProcess()
    made = TopicBridge(client, ("odom", "camera/depth/image_raw"), latch)  # type: ignore[arg-type]
    for node in nodes:
        made.expect(node.node)
        await made.open(node, process)  # type: ignore[arg-type]
    return made, client, process


DRIVER = protocol.Added("driver", [TF, ODOM], ["cmd_vel"])
LOCATOR = protocol.Added("locator", [TF], ["tf", "pose"])


async def test_sensor_data_reaches_local_nodes_without_the_cloud() -> None:
    made, client, process = await bridge(DRIVER)
    assert list(client.subscriptions) == ["tf"]
    made.published("odom", decode(Odometry, ODOMETRY))
    made.published("chatter", Twist())
    assert process.delivered == ["odom"]
    client.subscriptions["tf"](encode(TFMessage([])))
    assert process.delivered == ["odom", "tf"]


async def test_velocities_pass_the_latch_on_their_way_to_the_base_and_to_the_cloud() -> None:
    latch = FakeLatch()
    made, client, _ = await bridge(DRIVER, latch=latch)
    velocities: list[Twist] = []
    await client.subscribe("cmd_vel", Twist, velocities.append)
    said = protocol.Said("cmd_vel", "geometry_msgs/Twist", msgspec.Raw(encode(FAST)))
    made.on_message(said)
    latch.stopped = True
    made.on_message(said)
    forwarding = asyncio.create_task(made.run())
    await asyncio.sleep(0)
    forwarding.cancel()
    assert velocities == [FAST, Twist()]
    assert [message for _, message, _ in client.sent] == [FAST, Twist()]


CAMERA = protocol.Added("camera", [protocol.TopicName("camera/depth/image_raw", "sensor_msgs/Image")], ["scan"])


async def test_images_are_sent_to_the_cloud_only_without_a_local_scan_node() -> None:
    made, _, process = await bridge(DRIVER)
    image, odometry = Image(Header(), 0, 0, "16UC1", 0, 0, b""), decode(Odometry, ODOMETRY)
    before = len(process.delivered)
    assert made.published("camera/depth/image_raw", image)
    assert len(process.delivered) == before, "no local node subscribes to it"
    made.expect("camera")
    await made.open(CAMERA, process)  # type: ignore[arg-type]
    assert not made.published("camera/depth/image_raw", image)
    assert made.published("odom", odometry), "other nodes of the clone subscribe to it"
    assert made.owns("scan")
    await made.close("camera")
    assert made.published("camera/depth/image_raw", image)


async def test_messages_of_a_local_node_are_delivered_and_sent_to_the_cloud() -> None:
    made, client, process = await bridge(LOCATOR)
    running = asyncio.create_task(made.run())
    made.on_message(protocol.Said("tf", "tf2_msgs/TFMessage", msgspec.Raw(encode(TFMessage([])))))
    assert client.heard == ["tf"]
    assert process.delivered == [], "a node does not receive its own message"
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert client.sent == [("tf", TFMessage([]), True)]
    running.cancel()


async def test_results_are_never_dropped_and_commands_are_newest_only() -> None:
    made, client, _ = await bridge(DRIVER)
    result = encode(
        decode(MoveBaseActionResult, b'{"header":{},"status":{"goal_id":{"id":"g"},"status":3},"result":{}}')
    )
    made.on_message(protocol.Said("move_base/result", "move_base_msgs/MoveBaseActionResult", msgspec.Raw(result)))
    made.on_message(protocol.Said("cmd_vel", "geometry_msgs/Twist", msgspec.Raw(encode(FAST))))
    running = asyncio.create_task(made.run())
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert [(topic, newest) for topic, _, newest in client.sent] == [("move_base/result", False), ("cmd_vel", True)]
    running.cancel()


async def test_a_topic_is_owned_if_only_local_nodes_publish_it() -> None:
    made, _, _ = await bridge(DRIVER, LOCATOR)
    assert made.owns("cmd_vel")
    assert made.owns("pose")
    assert not made.owns("tf")
    assert not made.owns("map")
    await made.close("driver")
    assert not made.owns("cmd_vel")


async def test_a_topic_stays_subscribed_while_a_local_node_needs_it() -> None:
    made, client, _ = await bridge(DRIVER, LOCATOR)
    await made.close("driver")
    assert list(client.subscriptions) == ["tf"]
    await made.close("locator")
    assert client.subscriptions == {}


PLANNER = protocol.Added("planner", [TF, protocol.TopicName("move_base/goal", "move_base_msgs/MoveBaseActionGoal")], [])
SECOND = protocol.Added("second", PLANNER.subscribes, [])


async def test_messages_missed_during_a_move_are_delivered_once() -> None:
    made, client, process = await bridge(PLANNER)
    hear = client.subscriptions["move_base/goal"]
    hear(_goal("first"))
    client.subscriptions["tf"](encode(TFMessage([])))
    assert made.heard("planner") == [_mark("first")]
    came = [TopicMessage("move_base/goal", _goal(name).decode()) for name in ("first", "second")]
    for _ in range(2):
        made.deliver_missed("planner", came, process)  # type: ignore[arg-type]
    assert process.delivered == ["move_base/goal", "tf"]
    assert process.delivered_to_node == [("planner", "second")]
    assert made.heard("planner") == [_mark("first"), _mark("second")]


async def test_a_later_node_gets_messages_that_another_already_received() -> None:
    made, client, process = await bridge(PLANNER)
    client.subscriptions["move_base/goal"](_goal("first"))
    made.expect("second")
    await made.open(SECOND, process)  # type: ignore[arg-type]
    assert made.heard("second") == []
    made.deliver_missed("second", [TopicMessage("move_base/goal", _goal("first").decode())], process)  # type: ignore[arg-type]
    assert process.delivered_to_node == [("second", "first")]
    assert made.heard("planner") == [_mark("first")]


async def test_messages_of_a_local_node_count_as_received_by_the_others() -> None:
    made, _, _ = await bridge(PLANNER)
    made.on_message(protocol.Said("move_base/goal", "move_base_msgs/MoveBaseActionGoal", msgspec.Raw(_goal("own"))))
    assert made.heard("planner") == [_mark("own")]


def _mark(name: str) -> str:
    return fingerprint("move_base/goal", decode(MoveBaseActionGoal, _goal(name)))


def _goal(name: str) -> bytes:
    pose = b'{"position":{"x":0,"y":0},"orientation":{"z":0,"w":1}}'
    goal = b'{"target_pose":{"header":{"frame_id":"map"},"pose":%s}}' % pose
    return b'{"header":{},"goal_id":{"id":"%s"},"goal":%s}' % (name.encode(), goal)


ODOMETRY = (
    b'{"header":{"frame_id":"odom"},"child_frame_id":"base_link","pose":{"pose":{"position":{"x":0,"y":0},'
    b'"orientation":{"z":0,"w":1}}},"twist":{"twist":{}}}'
)


def test_images_of_the_client_reach_local_nodes_directly_by_default() -> None:
    assert {topic.name for topic in TOPICS.values() if topic.local} < set(SENSORS)


ADDED = protocol.Added(
    "move_base",
    [],
    [],
    [protocol.ServiceName("count", "std_srvs/Trigger"), protocol.ServiceName("horn", "std_srvs/Empty")],
)


class AdvertisingClient:
    """Records the advertised services."""

    def __init__(self) -> None:
        self.handlers: dict[str, Handler] = {}

    async def advertise_service(self, service: str, kind: ServiceType, handler: Handler) -> None:
        if service in self.handlers:
            raise Conflict(f"this client offers {service} already")
        self.handlers[service] = handler

    async def unadvertise_service(self, service: str) -> None:
        del self.handlers[service]


class CountingProcess:
    """Answers with the number of calls until it exits."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, bytes]] = []
        self.gone = False

    async def call(self, service: str, request: bytes) -> msgspec.Raw:
        self.asked.append((service, request))
        if self.gone:
            raise Unavailable("it is gone")
        return msgspec.Raw(b'{"success": true, "message": "%d"}' % len(self.asked))


async def test_services_of_a_local_node_are_advertised_and_answered() -> None:
    client, process = AdvertisingClient(), CountingProcess()
    services = NodeServices(client)  # type: ignore[arg-type]
    await services.open(ADDED, process)  # type: ignore[arg-type]
    assert list(client.handlers) == ["count", "horn"]
    answer = client.handlers["count"](Empty())
    assert not isinstance(answer, TriggerResponse)
    assert await answer == Trigger.response(True, "1")
    assert process.asked == [("count", b"{}")]
    process.gone = True
    with pytest.raises(Unavailable, match="it is gone"):
        await client.handlers["count"](Empty())  # type: ignore[misc]
    await services.close("move_base")
    await services.close("move_base")
    assert client.handlers == {}


async def test_a_service_that_the_robot_advertises_itself_is_kept(caplog: pytest.LogCaptureFixture) -> None:
    client, process = AdvertisingClient(), CountingProcess()
    services = NodeServices(client)  # type: ignore[arg-type]
    await client.advertise_service("horn", Trigger, lambda _: TriggerResponse(True))
    await services.open(ADDED, process)  # type: ignore[arg-type]
    assert "a service of move_base is not available on the robot" in caplog.text
    await services.close("move_base")
    assert list(client.handlers) == ["horn"]
