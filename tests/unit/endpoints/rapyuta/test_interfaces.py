"""Messages between robots of 2013, containers and other robots."""

import json
import struct
import zlib
from typing import Any

import pytest

from endpoints.place_client import MAX_WAITING
from engine.protocols import robot_link
from engine.protocols.refusals import Refusal
from ppaas.errors import NotFound, QuotaExceeded
from tests.support.endpoints.rapyuta import ClonePlace, StillRobot, error_in
from tests.support.endpoints.still_place import StillClient, answers, delivered
from tests.support.waiting import until

STRING, TWIST, SCAN, PLAN = "std_msgs/String", "geometry_msgs/Twist", "sensor_msgs/LaserScan", "nav_msgs/GetPlan"
HALF = {"linear": {"x": 0.5, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": -1.0}}


@pytest.fixture
async def created(robot: StillRobot) -> StillRobot:
    """Return a robot with the container c1."""
    assert await robot.do("CC", containerTag="c1") == []
    return robot


def _data(messages: list[dict[str, Any]]) -> dict[str, Any]:
    [message] = messages
    assert message["type"] == "DM", message
    data: dict[str, Any] = message["data"]
    return data


# -- topics ------------------------------------------------------------------------------------------------------------


async def test_a_message_of_the_robot_reaches_the_clone(created: StillRobot, place: ClonePlace) -> None:
    await created.joined("scan", "Subscriber", SCAN, "/scan")
    part = struct.pack("<3f", 1.0, float("inf"), 2.0)
    message = {"header": {"stamp": "2013-09-01T00:00:00.5", "frame_id": "base_scan"}, "ranges": part}
    assert await created.send("scan", SCAN, message) == []
    [(topic, scan)] = delivered(place)
    assert topic == "scan"
    assert scan["header"]["stamp"] == {"secs": 1377993600, "nsecs": 500_000_000}
    assert scan["ranges"] == [1.0, None, 2.0]


async def test_a_message_of_the_clone_reaches_the_robot(created: StillRobot, place: ClonePlace) -> None:
    await created.joined("drive", "Publisher", TWIST, "/cmd_vel")
    place.publish_json("cmd_vel", HALF)
    data = _data(created.received())
    assert (data["iTag"], data["type"], data["msg"]) == ("drive", TWIST, HALF)
    assert 0 < len(data["msgID"]) <= 255


async def test_a_forwarder_has_the_bytes_of_ros(created: StillRobot, place: ClonePlace) -> None:
    await created.joined("drive", "Publisher", TWIST, "/cmd_vel", "Forwarder")
    place.publish_json("cmd_vel", HALF)
    data = _data(created.received())
    assert struct.unpack("<6d", zlib.decompress(data["msg"])) == (0.5, 0.0, 0.0, 0.0, 0.0, -1.0)
    await created.joined("goal", "Subscriber", STRING, "/goal", "Forwarder")
    await created.send("goal", STRING, zlib.compress(struct.pack("<I", 2) + b"hi"))
    assert delivered(place) == [("goal", {"data": "hi"})]


@pytest.mark.parametrize(
    ("cls", "message", "text"),
    [
        ("std_msgs/Bool", {"data": True}, "does not match"),
        (STRING, "hi", "not an object"),
        (STRING, b"hi", "CompressedImage"),
    ],
)
async def test_a_message_that_is_not_of_the_interface_is_refused(
    created: StillRobot, place: ClonePlace, cls: str, message: Any, text: str
) -> None:
    await created.joined("goal", "Subscriber", STRING, "/goal")
    assert text in error_in(await created.send("goal", cls, message))
    assert delivered(place) == []


async def test_messages_for_no_interface_or_the_wrong_one_are_refused(created: StillRobot) -> None:
    assert "unknown interface" in error_in(await created.send("nothing", STRING, {"data": ""}))
    await created.joined("drive", "Publisher", TWIST, "/cmd_vel")
    assert "can not handle incoming messages" in error_in(await created.send("drive", TWIST, HALF))


async def test_a_message_without_a_connection_is_dropped(created: StillRobot) -> None:
    await created.add("tb1", "goal", "SubscriberConverter", STRING)
    assert await created.send("goal", STRING, {"data": "x"}) == []


async def test_what_the_clone_refuses_is_told(created: StillRobot, place: ClonePlace) -> None:
    await created.joined("goal", "Subscriber", STRING, "/goal")
    await created.send("goal", STRING, {"data": "x"})
    [message] = place.far.take(robot_link.Deliver)
    place.say(robot_link.MessageRefused(message.client, "goal", Refusal("invalid-input", "no such room")))
    assert error_in(created.received()) == "Invalid Request: no such room"


async def test_a_latched_message_reaches_each_robot_that_connects(
    created: StillRobot, other: StillRobot, place: ClonePlace
) -> None:
    lamp = StillClient(place)
    lamp.say(op="advertise", topic="/lamp", type=STRING, latch=True)
    lamp.say(op="publish", topic="/lamp", msg={"data": "on"})
    await created.add("c1", "lamp", "SubscriberInterface", STRING, "/lamp")
    for robot in (created, other):
        await robot.add(robot.robot.tag, "lamp", "PublisherConverter", STRING)
        found = await robot.do("CX", connect=[{"tagA": f"{robot.robot.tag}/lamp", "tagB": "c1/lamp"}])
        assert [message["data"]["msg"] for message in found if message["type"] == "DM"] == [{"data": "on"}]
    lamp.session.end()


async def test_robots_of_a_user_exchange_messages(created: StillRobot, other: StillRobot) -> None:
    await created.add("tb1", "say", "SubscriberConverter", "my_msgs/Word")
    await other.add("tb2", "hear", "PublisherConverter", "my_msgs/Word")
    [status] = await created.do("CX", connect=[{"tagA": "tb1/say", "tagB": "tb2/hear"}])
    assert status["data"] == {"topic": "iu", "iTag": "say", "status": True}
    await created.send("say", "my_msgs/Word", {"word": "hello"})
    assert [message["type"] for message in other.received()] == ["ST", "DM"]


async def test_a_peer_that_fails_keeps_a_message_from_no_other(
    created: StillRobot, other: StillRobot, place: ClonePlace, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError

    await created.joined("drive", "Publisher", TWIST, "/cmd_vel")
    await other.add("tb2", "hear", "PublisherConverter", TWIST)
    await other.do("CX", connect=[{"tagA": "tb2/hear", "tagB": "c1/drive"}])
    first = created.robot.interfaces["drive"]
    monkeypatch.setattr(first, "deliver", fail)
    place.publish_json("cmd_vel", HALF)
    assert _data(other.received())["msg"] == HALF


async def test_another_robot_uses_a_container(created: StillRobot, other: StillRobot, place: ClonePlace) -> None:
    await other.joined("goal", "Subscriber", STRING, "/goal")
    await other.send("goal", STRING, {"data": "from tb2"})
    assert delivered(place) == [("goal", {"data": "from tb2"})]
    await created.do("DC", containerTag="c1")
    [status] = other.received()
    assert status["data"] == {"topic": "iu", "iTag": "goal", "status": False}


# -- services ----------------------------------------------------------------------------------------------------------


async def test_a_robot_calls_a_service_of_the_clone(created: StillRobot, place: ClonePlace) -> None:
    await created.joined("plan", "ServiceProvider", PLAN, "/make_plan")
    place.answers["make_plan"] = b'{"plan": {"header": {"stamp": {"secs": 1, "nsecs": 0}}, "poses": []}}'
    request = {"tolerance": 0.5, "start": {"header": {"stamp": "1970-01-01T00:00:02"}}}
    assert await created.send("plan", PLAN, request, "request-7") == []
    await until(lambda: bool(place.called))
    assert place.called[0][1]["start"]["header"]["stamp"] == {"secs": 2, "nsecs": 0}
    data = _data(created.received())
    assert data["msgID"] == "request-7"
    assert data["msg"] == {"plan": {"header": {"stamp": "1970-01-01T00:00:01.000000"}, "poses": []}}


async def test_a_call_that_fails_is_an_error_with_its_id(created: StillRobot, place: ClonePlace) -> None:
    await created.joined("plan", "ServiceProvider", PLAN, "/make_plan")
    place.answers["make_plan"] = NotFound("room", "kitchen")
    await created.send("plan", PLAN, {}, "request-7")
    await until(lambda: bool(place.called))
    text = error_in(created.received())
    assert "request-7" in text and "kitchen" in text


async def test_a_call_without_a_connection_is_an_error(created: StillRobot) -> None:
    await created.add("tb1", "plan", "ServiceProviderConverter", PLAN)
    assert "not connected" in error_in(await created.send("plan", PLAN, {}))


async def test_a_provider_has_one_client(created: StillRobot) -> None:
    await created.joined("plan", "ServiceProvider", PLAN, "/make_plan")
    await created.add("c1", "second", "ServiceClientInterface", PLAN, "/make_plan")
    assert "at most" in error_in(await created.do("CX", connect=[{"tagA": "tb1/plan", "tagB": "c1/second"}]))


async def test_calls_without_an_answer_are_limited(created: StillRobot, place: ClonePlace) -> None:
    await created.joined("plan", "ServiceProvider", PLAN, "/make_plan")
    place.far.write = lambda _: None  # type: ignore[method-assign,assignment]
    for number in range(MAX_WAITING):
        assert await created.send("plan", PLAN, {}, str(number)) == []
    assert "at most" in error_in(await created.send("plan", PLAN, {}))
    messages = await created.do("DC", containerTag="c1")
    assert sum("closed" in str(message["data"]) for message in messages) == MAX_WAITING


@pytest.fixture
async def serving(created: StillRobot, place: ClonePlace) -> tuple[StillRobot, StillClient]:
    """Return a robot that offers the service lamp in its container, and a client that calls it."""
    await created.joined("lamp", "ServiceClient", "my_msgs/Switch", "/lamp")
    return created, StillClient(place, "operator")


async def test_a_robot_serves_calls_of_the_clone(serving: tuple[StillRobot, StillClient]) -> None:
    robot, caller = serving
    caller.say(op="call_service", service="/lamp", args={"on": True}, id="a")
    data = _data(robot.received())
    assert (data["iTag"], data["type"], data["msg"]) == ("lamp", "my_msgs/Switch", {"on": True})
    assert await robot.send("lamp", "my_msgs/Switch", {"done": True}, data["msgID"]) == []
    [answer] = caller.received()
    assert (answer["id"], answer["result"], answer["values"]) == ("a", True, {"done": True})
    text = error_in(await robot.send("lamp", "my_msgs/Switch", {"done": True}, data["msgID"]))
    assert "does not wait for a response" in text
    caller.session.end()


async def test_a_response_that_is_none_fails_the_call(serving: tuple[StillRobot, StillClient]) -> None:
    robot, caller = serving
    caller.say(op="call_service", service="/lamp", args={}, id="a")
    message_id = _data(robot.received())["msgID"]
    assert "not an object" in error_in(await robot.send("lamp", "my_msgs/Switch", 5, message_id))
    assert caller.received()[0]["result"] is False
    caller.session.end()


async def test_calls_fail_without_the_robot(serving: tuple[StillRobot, StillClient]) -> None:
    robot, caller = serving
    caller.say(op="call_service", service="/lamp", args={}, id="a")
    robot.received()
    await robot.do("CN", removeInterfaces=[{"endpointTag": "tb1", "interfaceTag": "lamp"}])
    assert "removed" in caller.received()[0]["values"]
    caller.say(op="call_service", service="/lamp", args={}, id="b")
    assert "not connected" in caller.received()[0]["values"]
    await robot.do("DC", containerTag="c1")
    caller.say(op="call_service", service="/lamp", args={}, id="c")
    [answer] = await answers(caller)
    assert (answer["result"], "lamp" in json.dumps(answer)) == (False, True)
    caller.session.end()


# -- slow robots -------------------------------------------------------------------------------------------------------


async def test_a_robot_that_does_not_read_answers_is_disconnected(
    created: StillRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_frame: bytes) -> None:
        raise QuotaExceeded("too many answers wait")

    monkeypatch.setattr(created.robot.outbox, "put_answer", full)
    await created.add("tb1", "say", "SubscriberConverter", STRING)
    await created.add("c1", "say", "PublisherInterface", STRING, "/goal")
    await created.do("CX", connect=[{"tagA": "tb1/say", "tagB": "c1/say"}])
    assert isinstance(created.robot.over.result(), QuotaExceeded)
