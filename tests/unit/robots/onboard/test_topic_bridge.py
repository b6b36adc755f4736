"""Messages of local nodes are delivered once, and directly where possible."""

import asyncio
from typing import Any

import msgspec

from ppaas.messages import decode, encode
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.message import Message
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.ppaas_msgs import TopicMessage
from ppaas.messages.sensor_msgs import Image
from ppaas.messages.std_msgs import Header
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.message_fingerprint import fingerprint
from robots.onboard.executor import protocol
from robots.onboard.topic_bridge import TopicBridge

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
        self.told: list[str] = []
        self.told_alone: list[tuple[str, str]] = []

    def tell(self, topic: str, payload: bytes, node: str = "") -> None:
        if node:
            self.told_alone.append((node, decode(MoveBaseActionGoal, payload).goal_id.id))
        else:
            self.told.append(topic)


async def bridge(*nodes: protocol.Added) -> tuple[TopicBridge, FakeClient, FakeProcess]:
    client, process = FakeClient(), FakeProcess()
    made = TopicBridge(client, ("odom", "camera/depth/image_raw"))  # type: ignore[arg-type]
    for node in nodes:
        made.expect(node.node)
        await made.open(node, process)  # type: ignore[arg-type]
    return made, client, process


DRIVER = protocol.Added("driver", [TF, ODOM], ["cmd_vel"])
LOCATOR = protocol.Added("locator", [TF], ["tf", "pose"])


async def test_what_the_robot_senses_reaches_its_nodes_without_the_cloud() -> None:
    made, client, process = await bridge(DRIVER)
    assert list(client.subscriptions) == ["tf"]
    made.published("odom", decode(Odometry, ODOMETRY))
    made.published("chatter", Twist())
    assert process.told == ["odom"]
    client.subscriptions["tf"](encode(TFMessage([])))
    assert process.told == ["odom", "tf"]


CAMERA = protocol.Added("camera", [protocol.TopicName("camera/depth/image_raw", "sensor_msgs/Image")], ["scan"])


async def test_images_go_to_the_cloud_only_while_nobody_here_makes_scans_of_them() -> None:
    made, _, process = await bridge(DRIVER)
    image, odometry = Image(Header(), 0, 0, "16UC1", 0, 0, b""), decode(Odometry, ODOMETRY)
    assert made.published("camera/depth/image_raw", image)
    made.expect("camera")
    await made.open(CAMERA, process)  # type: ignore[arg-type]
    assert not made.published("camera/depth/image_raw", image)
    assert made.published("odom", odometry), "others of the clone hear it"
    assert made.owns("scan")
    await made.close("camera")
    assert made.published("camera/depth/image_raw", image)


async def test_what_a_node_says_is_heard_here_at_once_and_told_to_the_cloud() -> None:
    made, client, process = await bridge(LOCATOR)
    running = asyncio.create_task(made.run())
    made.on_message(protocol.Said("tf", "tf2_msgs/TFMessage", msgspec.Raw(encode(TFMessage([])))))
    assert client.heard == ["tf"]
    assert process.told == [], "its own word does not come back to it"
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    assert client.sent == [("tf", TFMessage([]), True)]
    running.cancel()


async def test_results_and_goals_wait_for_the_link_and_commands_do_not() -> None:
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


async def test_only_what_nobody_else_says_is_an_echo() -> None:
    made, _, _ = await bridge(DRIVER, LOCATOR)
    assert made.owns("cmd_vel")
    assert made.owns("pose")
    assert not made.owns("tf")
    assert not made.owns("map")
    await made.close("driver")
    assert not made.owns("cmd_vel")


async def test_a_topic_is_heard_while_some_node_wants_it() -> None:
    made, client, _ = await bridge(DRIVER, LOCATOR)
    await made.close("driver")
    assert list(client.subscriptions) == ["tf"]
    await made.close("locator")
    assert client.subscriptions == {}


PLANNER = protocol.Added("planner", [TF, protocol.TopicName("move_base/goal", "move_base_msgs/MoveBaseActionGoal")], [])
SECOND = protocol.Added("second", PLANNER.subscribes, [])


async def test_what_came_while_a_node_moved_reaches_it_once() -> None:
    made, client, process = await bridge(PLANNER)
    hear = client.subscriptions["move_base/goal"]
    hear(_goal("first"))
    client.subscriptions["tf"](encode(TFMessage([])))
    assert made.heard("planner") == [_mark("first")]
    came = [TopicMessage("move_base/goal", _goal(name).decode()) for name in ("first", "second")]
    for _ in range(2):
        made.deliver_missed("planner", came, process)  # type: ignore[arg-type]
    assert process.told == ["move_base/goal", "tf"]
    assert process.told_alone == [("planner", "second")]
    assert made.heard("planner") == [_mark("first"), _mark("second")]


async def test_a_node_that_comes_later_has_heard_nothing_of_what_another_has() -> None:
    made, client, process = await bridge(PLANNER)
    client.subscriptions["move_base/goal"](_goal("first"))
    made.expect("second")
    await made.open(SECOND, process)  # type: ignore[arg-type]
    assert made.heard("second") == []
    made.deliver_missed("second", [TopicMessage("move_base/goal", _goal("first").decode())], process)  # type: ignore[arg-type]
    assert process.told_alone == [("second", "first")]
    assert made.heard("planner") == [_mark("first")]


async def test_what_a_local_node_says_has_reached_the_others() -> None:
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
