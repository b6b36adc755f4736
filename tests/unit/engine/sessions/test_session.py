"""Operations of a client, and what it and other clients receive, without sockets."""

import json
from collections.abc import Callable
from functools import partial
from typing import Any

import cbor2
import pytest

from engine.control.planning.plan_rate import PlanRate
from engine.master.quotas import Quota, Quotas
from engine.protocols import robot_link
from engine.sessions.outbox import FrameOutbox
from engine.sessions.session import PATH_SERVICES
from ppaas.errors import Unavailable
from ppaas.messages.nav_msgs import GetPlan
from ppaas.messages.ppaas_msgs import ComputePath
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.wire.names import NameScope
from tests.support.endpoints.still_place import StillClient, StillPlace, answers, error_of
from tests.support.waiting import patience


def test_path_services_are_the_planning_services_of_move_base() -> None:
    planning = [service for service in MoveBaseNode.services if service.type in (GetPlan, ComputePath)]
    assert {service.name for service in planning} == PATH_SERVICES


@pytest.mark.parametrize("spelling", ["move_base/make_plan", "/move_base/make_plan"])
async def test_a_call_over_the_path_quota_fails_and_is_not_sent(place: StillPlace, spelling: str) -> None:
    rate = PlanRate(Quotas(Quota(plans_per_minute=1)))
    client = StillClient(place, count_plan=partial(rate.take, "ann"))
    for number in ("first", "second"):
        client.say(op="call_service", service=spelling, id=number, args={})
    [call] = place.far.take(robot_link.ServiceCall)
    assert call.service == "move_base/make_plan"
    [refused] = await answers(client)
    assert (refused["id"], refused["result"]) == ("second", False)
    assert refused["values"].startswith("user 'ann' may request 1 paths a minute")
    client.session.end()


async def test_a_client_topic_reaches_each_subscriber_in_its_spelling(
    place: StillPlace, client: StillClient, other: StillClient
) -> None:
    other.say(op="subscribe", topic="/chatter", type="std_msgs/msg/Header", id="s1")
    [warning] = other.received()
    assert (warning["op"], warning["level"], warning["id"]) == ("status", "warning", "s1")
    client.say(op="publish", topic="/chatter", msg={}, id="p1")
    [refused] = client.received()
    assert refused["msg"].startswith("not-found") and refused["id"] == "p1"
    client.say(op="advertise", topic="chatter", type="std_msgs/Header", latch=True)
    client.say(op="publish", topic="chatter", msg={"stamp": {"secs": 1, "nsecs": 2}})
    assert client.received() == []
    rest = {"seq": 0, "frame_id": ""}
    message = {"stamp": {"sec": 1, "nanosec": 2}} | rest
    assert other.received() == [{"op": "publish", "topic": "/chatter", "msg": message}]
    client.say(op="subscribe", topic="chatter")
    message = {"stamp": {"secs": 1, "nsecs": 2}} | rest
    assert client.received() == [{"op": "publish", "topic": "chatter", "msg": message}]
    assert place.far.take(robot_link.Deliver) == []


ZERO = {"x": 0.0, "y": 0.0, "z": 0.0}


@pytest.mark.parametrize("kind", ["geometry_msgs/Twist", "geometry_msgs/msg/Twist"])
@pytest.mark.parametrize("encoded", [json.dumps, cbor2.dumps])
@pytest.mark.parametrize("compression", ["none", "cbor"])
async def test_a_message_between_clients_is_complete_and_of_its_type(
    client: StillClient, other: StillClient, kind: str, encoded: Callable[[Any], Any], compression: str
) -> None:
    client.say(op="advertise", topic="joystick", type=kind)
    other.say(op="subscribe", topic="joystick", compression=compression)
    client.send(encoded({"op": "publish", "topic": "joystick", "msg": {"linear": {"x": 0.5}}}))
    [frame] = other.received()
    assert frame["msg"] == {"linear": ZERO | {"x": 0.5}, "angular": ZERO}
    client.send(encoded({"op": "publish", "topic": "joystick", "id": "p", "msg": {"linear": "fast"}}))
    refused = error_of(client.received())
    assert refused["id"] == "p" and "$.linear" in refused["msg"]
    assert other.received() == [] and not client.session.over.done()


async def test_a_message_between_clients_of_an_unknown_type_passes_as_it_is(
    client: StillClient, other: StillClient
) -> None:
    client.say(op="advertise", topic="chat", type="my_msgs/Chat")
    other.say(op="subscribe", topic="chat", type="my_msgs/msg/Chat")
    client.say(op="publish", topic="chat", msg={"linear": "fast"})
    assert other.received()[-1]["msg"] == {"linear": "fast"}


async def test_a_topic_is_removed_with_its_last_advertiser(client: StillClient, other: StillClient) -> None:
    other.say(op="advertise", topic="chatter", type="std_msgs/String", id="a")
    client.say(op="advertise", topic="/chatter", type="std_msgs/msg/String")
    other.say(op="unadvertise", topic="chatter", id="a")
    client.say(op="publish", topic="chatter", msg={"data": "x"})
    assert client.received() == other.received() == []
    client.session.end()
    other.say(op="publish", topic="chatter", msg={"data": "x"})
    assert [frame["op"] for frame in other.received()] == ["status"]


@pytest.mark.parametrize(
    ("operation", "slug"),
    [
        ({"op": "advertise", "topic": "goal", "type": "std_msgs/Bool"}, "conflict"),
        ({"op": "advertise", "topic": "x", "type": "Bool"}, "unknown-type"),
        ({"op": "advertise", "topic": "x y", "type": "std_msgs/Bool"}, "malformed-message"),
        ({"op": "advertise", "topic": "scan", "type": "sensor_msgs/LaserScan"}, "not-permitted"),
        ({"op": "unadvertise", "topic": "x"}, "not-found"),
        ({"op": "subscribe", "topic": "map", "type": "std_msgs/Bool"}, "conflict"),
        ({"op": "subscribe", "topic": "map", "type": "?"}, "unknown-type"),
        ({"op": "advertise_service", "service": "make_plan", "type": "nav_msgs/GetPlan"}, "conflict"),
        ({"op": "advertise_service", "service": "x", "type": ""}, "unknown-type"),
        ({"op": "unadvertise_service", "service": "x"}, "not-found"),
        ({"op": "service_response", "service": "x", "result": True, "id": "7"}, "not-found"),
        ({"op": "service_response", "service": "x", "result": True, "id": "²"}, "not-found"),
        ({"op": "service_response", "service": "x", "result": True}, "not-found"),
        ({"op": "cancel_action_goal", "action": "move_base", "id": "x"}, "not-found"),
    ],
)
async def test_invalid_operations_are_reported_with_the_error_slug(
    operation: dict[str, Any], slug: str, other: StillClient
) -> None:
    other.say(**operation)
    [frame] = other.received()
    assert (frame["op"], frame["level"]) == ("status", "error")
    assert frame["msg"].startswith(f"{slug}: "), frame


async def test_a_refused_subscription_delivers_nothing(place: StillPlace, client: StillClient) -> None:
    client.say(op="subscribe", topic="map", type="std_msgs/Bool")
    client.received()
    place.publish_json("map", {})
    assert client.received() == []


async def test_a_throttled_topic_still_delivers_the_last_message(place: StillPlace, client: StillClient) -> None:
    client.say(op="subscribe", topic="goal", throttle_rate=30)
    client.say(op="subscribe", topic="map", throttle_rate=60_000)
    for number in range(5):
        place.publish_json("map", {"n": number})
        place.publish_json("goal", {"n": number})
    first = client.received()
    assert [frame["msg"]["n"] for frame in first] == [0, 0]
    [last] = await answers(client)
    assert (last["topic"], last["msg"]["n"]) == ("goal", 4)


async def test_an_outbox_full_of_answers_disconnects_its_client(
    client: StillClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(self: FrameOutbox, frame: str, fragment_size: int, sent: object) -> None:
        raise Unavailable("full")

    monkeypatch.setattr(FrameOutbox, "put_answer", full)
    client.say(op="call_service", service="/move_base/_action/cancel_goal")
    async with patience(5):
        assert str(await client.session.over) == "full"


# -- diagnosis ---------------------------------------------------------------------------------------------------------


async def test_refused_operations_of_the_robot_are_noted_at_its_place_by_topic() -> None:
    place = StillPlace()
    robot, operator = StillClient(place, names=NameScope(["tb1"])), StillClient(place, "operator")
    robot.say(op="publish", topic="/tb1/lidar", msg={})
    operator.say(op="publish", topic="/elsewhere", msg={})
    robot.send("not JSON")
    assert set(place.link_facts().refused) == {"lidar", ""}
    assert "unknown topic 'lidar'" in place.link_facts().refused["lidar"]


async def test_subscriptions_of_the_robot_are_known_at_its_place_until_it_leaves() -> None:
    place = StillPlace()
    robot = StillClient(place)
    robot.say(op="subscribe", topic="/cmd_vel")
    StillClient(place, "operator").say(op="subscribe", topic="/map")
    assert place.link_facts().subscribed == ("cmd_vel",)
    robot.session.end()
    assert place.link_facts().subscribed == ()
